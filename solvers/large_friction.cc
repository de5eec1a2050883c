#include "solvers/large_friction.h"

#include "core/problem/extended_error.h"

namespace bipot {
namespace {

// From this friction on, rounding of the criterion in double precision may pass for convergence.
constexpr double kLargeFriction = 1e4;
// What the extended figure may exceed the tolerance by: the solver could not see it.
constexpr double kExtendedGrace = 1.25;

}  // namespace

ExtendedClaim claim_in_extended_precision(const ContactProblem& p, const SolverOptions& options,
                                          const Eigen::Ref<const Vector>& s) {
  ExtendedClaim claim;
  if (options.stop != StopTest::kGuarded || p.num_contacts() == 0) return claim;
  if (!(p.mu.maxCoeff() >= kLargeFriction)) return claim;
  claim.error = extended_guarded_error(p, s);
  claim.holds = !(claim.error > kExtendedGrace * options.tol);
  return claim;
}

}  // namespace bipot
