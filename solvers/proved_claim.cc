#include "solvers/proved_claim.h"

#include "core/problem/extended_error.h"
#include "core/problem/rounding_bound.h"

namespace bipot {

ProvedClaim prove_claim(const ContactProblem& p, const SolverOptions& options,
                        const Eigen::Ref<const Vector>& s, const ContactError& error) {
  ProvedClaim claim;
  if (options.stop != StopTest::kGuarded || p.num_contacts() == 0) return claim;
  const double hidden = rounding_bound(p, s, Precision::kDouble, options.share).guarded();
  if (error.guarded() + hidden <= options.tol) return claim;
  const double extended = extended_guarded_error(p, s, options.share);
  const double hidden_there = rounding_bound(p, s, Precision::kExtended, options.share).guarded();
  claim.error = extended + hidden_there;
  // In software only where the figure lies within its own rounding.
  if (claim.error > options.tol && !(extended - hidden_there > options.tol)) {
    claim.error = quadruple_guarded_error(p, s, options.share) +
                  rounding_bound(p, s, Precision::kQuadruple, options.share).guarded();
  }
  claim.holds = claim.error <= options.tol;
  return claim;
}

}  // namespace bipot
