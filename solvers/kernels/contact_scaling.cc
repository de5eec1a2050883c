#include "solvers/kernels/contact_scaling.h"

#include <utility>

#include "core/criterion/error_terms.h"

namespace bipot {
namespace {

// Ratio of tangential to normal mobility below which only rounding remains.
constexpr double kNoMobility = 1e-12;

ContactScaling with_mu(const ContactProblem& p, Vector impulse, Vector velocity) {
  ContactScaling scaling{std::move(impulse), std::move(velocity), p.mu, p.mu_r, p.mu_spin};
  const auto change = [&](Vector& coefficients, int row) {
    for (int c = 0; c < static_cast<int>(coefficients.size()) && p.dim > 1; ++c) {
      coefficients[c] *= scaling.impulse[c * p.dim + row] / scaling.impulse[c * p.dim];
    }
  };
  change(scaling.mu, 1);
  change(scaling.mu_r, p.plain_dim());
  change(scaling.mu_spin, p.dim - 1);
  return scaling;
}

}  // namespace

Vector mean_diagonal(const ContactProblem& p, const Vector& diagonal) {
  Vector mean(p.num_rows());
  const int d = p.dim, plain = p.plain_dim(), turns = p.rolls() ? plain - 1 : 0;
  const Vector arms = rolling_arms(p, diagonal);
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double normal = diagonal[c * d];
    const auto take_mean = [&](int first, int count, double least, double instead) {
      double sum = 0;
      for (int k = first; k < first + count; ++k) sum += diagonal[c * d + k] / count;
      if (!(sum > least)) sum = instead;
      for (int k = first; k < first + count; ++k) mean[c * d + k] = sum;
    };
    mean[c * d] = normal;
    take_mean(1, plain - 1, kNoMobility * normal, normal);
    if (turns == 0) continue;
    const double turning = normal / (arms[c] * arms[c]);
    take_mean(plain, turns, kNoMobility * turning, turning);
    if (d == 6) take_mean(5, 1, kNoMobility * turning, turning);
  }
  return mean;
}

ContactScaling equilibrated_scaling(const ContactProblem& p, const Vector& diagonal) {
  Vector root = mean_diagonal(p, diagonal).cwiseSqrt();
  Vector inverse = root.cwiseInverse();
  return with_mu(p, std::move(root), std::move(inverse));
}

ContactScaling physical_scaling(const ContactProblem& p, const Vector& delassus_diagonal) {
  Vector impulse = p.row_scale.size() == 0 ? Vector(Vector::Ones(p.num_rows()))
                                           : Vector(p.row_scale.cwiseInverse());
  Vector velocity = impulse;
  const Vector arms = rolling_arms(p, delassus_diagonal);
  for (int c = 0; c < static_cast<int>(arms.size()); ++c) {
    const int turns = p.dim - p.plain_dim();
    impulse.segment((c + 1) * p.dim - turns, turns) /= arms[c];
    velocity.segment((c + 1) * p.dim - turns, turns) *= arms[c];
  }
  return with_mu(p, std::move(impulse), std::move(velocity));
}

}  // namespace bipot
