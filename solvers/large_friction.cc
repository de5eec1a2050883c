#include "solvers/large_friction.h"

#include <algorithm>
#include <cmath>

#include "core/problem/extended_error.h"
#include "core/problem/rounding_bound.h"

namespace bipot {
namespace {

// From this friction on, the rounding of a single impulse may be what keeps an answer from the tolerance.
constexpr double kLargeFriction = 1e4;
constexpr int kRounds = 10;

bool is_large(const ContactProblem& p) {
  return p.num_contacts() > 0 && p.mu.maxCoeff() >= kLargeFriction;
}

}  // namespace

ExtendedClaim claim_in_extended_precision(const ContactProblem& p, const SolverOptions& options,
                                          const Eigen::Ref<const Vector>& s,
                                          const ContactError& error) {
  ExtendedClaim claim;
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

double cancel_rounding(const ContactProblem& p, const SolverOptions& options,
                       ContactErrorEvaluator& evaluate, Vector& s) {
  if (!is_large(p)) return evaluate(s).guarded();
  // What is not below `best` in double precision need not be looked at in the dearer one.
  const auto judge = [&](const Vector& x, double best) {
    const double error = evaluate(x).guarded();
    if (!(error < best)) return error;
    return std::max(error, extended_guarded_error(p, evaluate.impulse()));
  };
  double error = judge(s, kInfinity);
  bool better = true;
  for (int round = 0; round < kRounds && better && error > options.tol; ++round) {
    better = false;
    if (options.cancelled && options.cancelled()) break;
    for (double& entry : s) {
      if (entry == 0) continue;
      for (const double towards : {-kInfinity, kInfinity}) {
        const double before = entry;
        entry = std::nextafter(before, towards);
        const double changed = judge(s, error);
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
