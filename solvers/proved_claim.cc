#include "solvers/proved_claim.h"

#include "core/criterion/extended_error.h"
#include "core/criterion/rounding_bound.h"

namespace bipot {
namespace {

constexpr double kTrifle = 1e-3;  // of the tolerance

}  // namespace

ProvedClaim prove_claim(const ContactProblem& p, const SolverOptions& options,
                        const Eigen::Ref<const Vector>& s, const ContactError& error,
                        const ErrorShare& share) {
  if (options.stop != StopTest::kGuarded || p.num_contacts() == 0) return {};
  ProvedClaim claim;
  const int threads = options.execution.threads;
  const RoundedSums sums = rounded_sums(p, s, threads);
  const auto hidden = [&](Precision precision) {
    return rounding_bound(sums, p.num_contacts(), precision, share).guarded();
  };
  if (error.guarded() + hidden(Precision::kDouble) <= options.tol) return claim;
  const double extended = extended_guarded_error(p, s, share, threads);
  const double hidden_there = hidden(Precision::kExtended);
  claim.error = extended + hidden_there;
  // In software only if the error lies within its own rounding and matters. Else the solver's next
  // iterate is as good, and not at the tolerance to five digits.
  const bool trifle = hidden_there <= kTrifle * options.tol;
  if (claim.error > options.tol && !(extended - hidden_there > options.tol) && !trifle) {
    claim.error = quadruple_guarded_error(p, s, share, threads) + hidden(Precision::kQuadruple);
  }
  claim.holds = claim.error <= options.tol;
  return claim;
}

}  // namespace bipot
