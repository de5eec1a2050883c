#include "solvers/prepared_problem.h"

namespace bipot {

const ProvedClaim* PreparedProblem::proved(double tol, const Eigen::Ref<const Vector>& s) const {
  const bool same =
      tol == proved_tol_ && s.size() == proved_impulse_.size() && s == proved_impulse_;
  return same ? &proved_claim_ : nullptr;
}

void PreparedProblem::remember(double tol, const Eigen::Ref<const Vector>& s,
                               const ProvedClaim& claim) {
  proved_tol_ = tol;
  proved_impulse_ = s;
  proved_claim_ = claim;
}

PreparedProblem* prepared(const ContactProblem& problem, const SolverOptions& options) {
  PreparedProblem* const known = options.prepared;
  return known != nullptr && known->serves(problem, options.execution.threads) ? known : nullptr;
}

ContactErrorEvaluator criterion_of(const ContactProblem& problem, const SolverOptions& options) {
  if (PreparedProblem* const known = prepared(problem, options)) {
    return {known->criterion(), options.share};
  }
  return ContactErrorEvaluator(problem, options.execution.threads, options.share);
}

}  // namespace bipot
