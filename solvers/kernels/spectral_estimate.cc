#include "solvers/kernels/spectral_estimate.h"

#include <cmath>
#include <random>

namespace bipot {

double spectral_bound(const ContactProblem& p, const Vector& scale) {
  const SparseRows absolute = p.has_delassus()
                                  ? SparseRows(p.W.cwiseAbs())
                                  : SparseRows(assemble_delassus(p.A, p.H, p.dim).cwiseAbs());
  const Vector sums = absolute * scale;
  return sums.cwiseProduct(scale).maxCoeff();
}

double spectral_estimate(const ContactProblem& p, const DelassusOperator& delassus,
                         const Vector& scale, int iterations) {
  std::mt19937 engine(1);
  Vector x(p.num_rows()), scaled(p.num_rows()), y(p.num_rows());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    x[i] = static_cast<double>(engine()) * 0x1.0p-31 - 1;
  }
  x.normalize();
  double norm = 0;
  for (int k = 0; k < iterations; ++k) {
    scaled = scale.cwiseProduct(x);
    delassus.apply(scaled, y);
    y.array() *= scale.array();
    norm = y.norm();
    if (!(norm > 0)) break;
    x = y / norm;
  }
  return norm;
}

}  // namespace bipot
