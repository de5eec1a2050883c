#include "solvers/kernels/spectral_estimate.h"

#include <random>

namespace bipot {
namespace {

/// The rows that are here of a vector that is drawn for the whole: a few nanoseconds a row.
Vector drawn_vector(ContactSpace& space) {
  const int d = space.problem().dim;
  const std::vector<int>* const numbers = space.numbers();
  std::mt19937 engine(1);
  Vector x(space.problem().num_rows());
  Eigen::Index next = 0;
  for (int c = 0; c < space.whole_contacts(); ++c) {
    const bool here = numbers == nullptr ||
                      (next < x.size() && (*numbers)[to_size(static_cast<int>(next) / d)] == c);
    for (int k = 0; k < d; ++k) {
      const double drawn = static_cast<double>(engine()) * 0x1.0p-31 - 1;
      if (here) x[next++] = drawn;
    }
  }
  return x;
}

}  // namespace

double spectral_estimate(ContactSpace& space, const Vector& scale, int iterations) {
  Vector x = drawn_vector(space), scaled(x.size()), y(x.size());
  double norm = space.norm(x);
  if (norm > 0) x /= norm;
  norm = 0;
  for (int k = 0; k < iterations; ++k) {
    scaled = scale.cwiseProduct(x);
    space.apply(scaled, y);
    y.array() *= scale.array();
    norm = space.norm(y);
    if (!(norm > 0)) break;
    x = y / norm;
  }
  return norm;
}

}  // namespace bipot
