#include "solvers/interior/proximal_newton.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "solvers/kernels/contact_residual.h"

namespace bipot {
namespace {

constexpr double kTangentWeight = 5;
constexpr double kStartDelta = 0.1, kSmallestDelta = 1e-6, kMostDelta = 1e2;
constexpr double kSolved = 0.5;      // |f| over its first value: the anchor moves
constexpr double kGood = 0.5;        // |f| over that before a step: the step is not shortened
constexpr double kNoProgress = 0.9;  // the same: delta grows
constexpr int kHalvings = 3;         // of a step
constexpr int kMostSteps = 8;        // for one anchor
constexpr double kGrowth = 4, kCautious = 0.7;
constexpr double kQuick = 1e-2;  // |f| over its first value, after a step to a tenth of delta
constexpr double kRounding = 30 * std::numeric_limits<double>::epsilon();

/// Factor of delta after an anchor that needed `steps`; `fall` is |f| over its first value.
double fall_of_delta(int steps, double fall) {
  if (steps == 1) return fall < kQuick ? 0.1 : 0.3;
  if (steps == 2) return 0.3;
  return steps == 3 ? 0.7 : 1;
}

/// The equation of one anchor and delta.
template <ContactRows D>
struct AnchoredEquation {
  const ContactProblem& problem;
  const DelassusOperator& delassus;
  Vector weights;
  std::vector<double> jacobians;  ///< J rho, row-major blocks
  Vector anchor, f, u = {};
  double size = 0;  ///< of s, in the norm of f

  AnchoredEquation(const ContactProblem& p, const DelassusOperator& W, Vector diagonal,
                   const Vector& start)
      : problem(p),
        delassus(W),
        weights(std::move(diagonal)),
        jacobians(to_size(p.num_contacts() * D * D)),
        anchor(start),
        f(start.size()) {
    for (int i = 0; i < p.num_rows(); ++i) {
      if (i % D != 0) weights[i] *= kTangentWeight;
    }
  }

  /// f and the Jacobian at s; the norm of f, the root of an energy.
  double operator()(const Vector& s, double delta) {
    delassus.velocity(s, u);
    for (int c = 0; c < problem.num_contacts(); ++c) {
      const Local<D> rho = (delta * weights.segment<D>(c * D)).cwiseInverse();
      const Local<D> z = local<D>(anchor, c) - rho.cwiseProduct(local<D>(u, c));
      Eigen::Matrix<double, D.count, D.count> jacobian;
      f.segment<D>(c * D) =
          split_projection<D>(z, friction_of<D>(problem, c), jacobian) - local<D>(s, c);
      Eigen::Map<Eigen::Matrix<double, D.count, D.count, Eigen::RowMajor>> block(
          &jacobians[to_size(c * D * D)]);
      block = jacobian * rho.asDiagonal();
    }
    size = std::sqrt(s.dot(weights.cwiseProduct(s)));
    return std::sqrt(f.dot(weights.cwiseProduct(f)));
  }
};

template <ContactRows D>
StageEnd follow(AnchoredEquation<D> equation, ShiftedDelassus& shifted, InteriorRun& run,
                int max_iterations) {
  Vector s = equation.anchor, step, before;
  double delta = kStartDelta, failed = 0;
  double first = equation(s, delta), now = first;
  int steps = 0;  // from this anchor
  for (int k = 0; k < max_iterations; ++k) {
    if (!shifted.factor(equation.jacobians)) return StageEnd::kFailed;
    shifted.solve(equation.f, step);
    before = s;
    double length = 1, best = 1;
    double residual = kInfinity;
    for (int j = 0; j <= kHalvings; ++j, length *= 0.5) {
      s = before + length * step;
      const double here = equation(s, delta);
      if (here < residual) {
        residual = here;
        best = length;
      } else if (j > 0) {
        break;
      }
      if (j == 0 && residual <= kGood * now) break;
    }
    if (!std::isfinite(residual)) return StageEnd::kFailed;
    s = before + best * step;
    if (run.next(s, delta)) return StageEnd::kStop;
    ++steps;
    if (residual <= kSolved * first) {
      const double next = delta * fall_of_delta(steps, residual / first);
      if (next <= failed) {
        delta = std::max(next, kCautious * delta);
        failed *= kCautious;  // the anchor has moved: the failure fades
      } else {
        delta = next;
      }
      delta = std::max(delta, kSmallestDelta);
    } else if (residual > kNoProgress * now || steps == kMostSteps) {
      if (residual >= first) s = equation.anchor;
      failed = delta;
      delta *= kGrowth;
      if (delta > kMostDelta) return StageEnd::kStuck;
    } else {
      now = equation(s, delta);
      continue;
    }
    equation.anchor = s;
    steps = 0;
    now = first = equation(s, delta);
    // Where 1/delta magnifies the rounding of u to the size of f, a larger delta goes on.
    while (first <= kRounding / delta * equation.size) {
      if (delta >= kStartDelta) return StageEnd::kStuck;
      delta *= 10;
      now = first = equation(s, delta);
    }
  }
  return StageEnd::kLimit;
}

}  // namespace

StageEnd proximal_newton(const ContactProblem& problem, const DelassusOperator& delassus,
                         ShiftedDelassus& shifted, const Vector& weights, const Vector& start,
                         InteriorRun& run, int max_iterations) {
  return dispatch_rows(problem, [&](auto d) {
    return follow(AnchoredEquation<d()>(problem, delassus, weights, start), shifted, run,
                  max_iterations);
  });
}

}  // namespace bipot
