#include "solvers/homotopy/proximal_term.h"

#include <algorithm>
#include <cmath>

namespace bipot {
namespace {

// Bounds of the first factor.
constexpr double kLeast = 0.1, kMost = 10;
// The second factor, and the fraction of the cone within which it holds.
constexpr double kSticking = 0.1, kInside = 0.8;

/// Mean of the normal impulses that are not zero; 0 if all are.
double mean_impulse(const LawProblem& problem, const Vector& s) {
  double sum = 0;
  int bearing = 0;
  for (int i = 0; i < problem.num_contacts(); ++i) {
    const double own = s[Eigen::Index{i} * problem.dim];
    if (own <= 0) continue;
    sum += own;
    ++bearing;
  }
  return bearing > 0 ? sum / bearing : 0;
}

}  // namespace

void proximal_term(const LawProblem& problem, const LawPoint& point, const Vector& anchor,
                   double delta, Vector& term) {
  const int d = problem.dim;
  const double mean = mean_impulse(problem, anchor);
  term.setConstant(problem.num_rows(), delta);
  for (int i = 0; i < problem.num_contacts(); ++i) {
    const Eigen::Index n = Eigen::Index{i} * d;
    const double own = anchor[n];
    if (mean > 0) term.segment(n, d) *= own * kMost > mean ? std::max(kLeast, mean / own) : kMost;
    const auto sticks = [&](int k) {
      return !has(point.cell[to_size(i)], k == 1 ? Column::kSliding : Column::kRolling) &&
             std::abs(anchor[n + k]) < kInside * problem.bound(i, k) * own;
    };
    if (d > 1 && sticks(1) && (d == 2 || sticks(2))) {
      term.segment(n, d) *= kSticking;
    }
  }
}

}  // namespace bipot
