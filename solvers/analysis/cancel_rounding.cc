#include "solvers/analysis/cancel_rounding.h"

#include <algorithm>
#include <cmath>

#include "core/criterion/extended_error.h"

namespace bipot {
namespace {

// From this friction on, the rounding of a single impulse may keep an answer from the tolerance.
constexpr double kLargeFriction = 1e4;
constexpr int kRounds = 10;

bool is_large(const ContactProblem& p) {
  return p.num_contacts() > 0 && p.mu.maxCoeff() >= kLargeFriction;
}

}  // namespace

double cancel_rounding(const ContactProblem& p, const SolverOptions& options,
                       ContactErrorEvaluator& evaluate, Vector& s) {
  if (!is_large(p)) return evaluate(s).guarded();
  // An error not below `best` in double precision is not evaluated in extended precision.
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
