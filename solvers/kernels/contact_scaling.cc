#include "solvers/kernels/contact_scaling.h"

#include <utility>

namespace bipot {
namespace {

// Ratio of tangential to normal mobility below which only rounding remains.
constexpr double kNoMobility = 1e-12;

ContactScaling with_mu(const ContactProblem& p, Vector impulse, Vector velocity) {
  ContactScaling scaling{std::move(impulse), std::move(velocity), p.mu};
  for (int c = 0; c < p.num_contacts() && p.dim > 1; ++c) {
    scaling.mu[c] *= scaling.impulse[c * p.dim + 1] / scaling.impulse[c * p.dim];
  }
  return scaling;
}

}  // namespace

Vector mean_diagonal(const ContactProblem& p, const Vector& diagonal) {
  Vector mean(p.num_rows());
  const int d = p.dim;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double normal = diagonal[c * d];
    double tangential = 0;
    for (int k = 1; k < d; ++k) tangential += diagonal[c * d + k] / (d - 1);
    if (!(tangential > kNoMobility * normal)) tangential = normal;
    mean[c * d] = normal;
    for (int k = 1; k < d; ++k) mean[c * d + k] = tangential;
  }
  return mean;
}

ContactScaling equilibrated_scaling(const ContactProblem& p, const Vector& diagonal) {
  Vector root = mean_diagonal(p, diagonal).cwiseSqrt();
  Vector inverse = root.cwiseInverse();
  return with_mu(p, std::move(root), std::move(inverse));
}

ContactScaling physical_scaling(const ContactProblem& p) {
  Vector inverse = p.row_scale.size() == 0 ? Vector(Vector::Ones(p.num_rows()))
                                           : Vector(p.row_scale.cwiseInverse());
  Vector copy = inverse;
  return with_mu(p, std::move(inverse), std::move(copy));
}

}  // namespace bipot
