#include "solvers/kernels/contact_scaling.h"

#include <cmath>

namespace bipot {
namespace {

ContactScaling with_mu(const ContactProblem& p, Vector impulse, Vector velocity) {
  ContactScaling scaling{std::move(impulse), std::move(velocity), p.mu};
  for (int c = 0; c < p.num_contacts() && p.dim > 1; ++c) {
    scaling.mu[c] *= scaling.impulse[c * p.dim + 1] / scaling.impulse[c * p.dim];
  }
  return scaling;
}

}  // namespace

ContactScaling equilibrated_scaling(const ContactProblem& p, const Vector& diagonal) {
  Vector root(p.num_rows());
  const int d = p.dim;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double w_nn = diagonal[c * d];
    root[c * d] = std::sqrt(w_nn);
    double tangential = 0;
    for (int k = 1; k < d; ++k) tangential += diagonal[c * d + k] / (d - 1);
    // A contact without tangential mobility (rounded data) is scaled by its normal part.
    if (!(tangential > 1e-12 * w_nn)) tangential = w_nn;
    for (int k = 1; k < d; ++k) root[c * d + k] = std::sqrt(tangential);
  }
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
