#include "solvers/contact_space.h"

namespace bipot {

WholeSpace::WholeSpace(const ContactProblem& problem, int threads, const ErrorShare& share)
    : problem_(problem),
      share_(share),
      evaluator_(problem, threads, share),
      proof_(std::make_shared<Proof>()) {}

WholeSpace::WholeSpace(const WholeSpace& made, const ErrorShare& share)
    : problem_(made.problem_),
      share_(share),
      evaluator_(made.evaluator_, share),
      proof_(made.proof_) {}

double WholeSpace::norm_bound(const Vector& scale) {
  const ContactProblem& p = problem_;
  const SparseRows absolute = p.has_delassus()
                                  ? SparseRows(p.W.cwiseAbs())
                                  : SparseRows(assemble_delassus(p.A, p.H, p.dim).cwiseAbs());
  const Vector sums = absolute * scale;
  return sums.cwiseProduct(scale).maxCoeff();
}

ProvedClaim WholeSpace::prove(const SolverOptions& options, const Eigen::Ref<const Vector>& s,
                              const ContactError& error) {
  if (options.stop != StopTest::kGuarded || problem_.num_contacts() == 0) return {};
  // A solver's last iterate returns here with the result of solve().
  const bool plain = share_ == ErrorShare{};
  const bool known = plain && proof_->tol == options.tol && s.size() == proof_->impulse.size() &&
                     s == proof_->impulse;
  if (known) return proof_->claim;
  const ProvedClaim claim = prove_claim(problem_, options, s, error, share_);
  if (plain && claim.holds) *proof_ = {options.tol, s, claim};
  return claim;
}

}  // namespace bipot
