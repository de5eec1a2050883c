#include "solvers/large_friction.h"

#include <algorithm>
#include <cmath>

#include "core/problem/extended_error.h"

namespace bipot {
namespace {

// From this friction on, rounding of the criterion in double precision may pass for convergence.
constexpr double kLargeFriction = 1e4;
// What the extended figure may exceed the tolerance by: the solver could not see it.
constexpr double kExtendedGrace = 1.25;
constexpr int kRounds = 10;

bool is_large(const ContactProblem& p) {
  return p.num_contacts() > 0 && p.mu.maxCoeff() >= kLargeFriction;
}

}  // namespace

ExtendedClaim claim_in_extended_precision(const ContactProblem& p, const SolverOptions& options,
                                          const Eigen::Ref<const Vector>& s) {
  ExtendedClaim claim;
  if (options.stop != StopTest::kGuarded || !is_large(p)) return claim;
  claim.error = extended_guarded_error(p, s);
  claim.holds = !(claim.error > kExtendedGrace * options.tol);
  return claim;
}

double cancel_rounding(const ContactProblem& p, const SolverOptions& options,
                       ContactErrorEvaluator& evaluate, Vector& s) {
  if (!is_large(p)) return evaluate(s).guarded();
  const auto judge = [&](const Vector& x) {
    const double error = evaluate(x).guarded();
    return std::max(error, extended_guarded_error(p, evaluate.impulse()) / kExtendedGrace);
  };
  double error = judge(s);
  bool better = true;
  for (int round = 0; round < kRounds && better && error > options.tol; ++round) {
    better = false;
    if (options.cancelled && options.cancelled()) break;
    for (double& entry : s) {
      if (entry == 0) continue;
      for (const double towards : {-kInfinity, kInfinity}) {
        const double before = entry;
        entry = std::nextafter(before, towards);
        const double changed = judge(s);
        if (changed < error) {
          error = changed;
          better = true;
        } else {
          entry = before;
        }
      }
    }
  }
  return error;
}

}  // namespace bipot
