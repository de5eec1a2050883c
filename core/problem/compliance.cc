#include "core/problem/compliance.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/base/triplets.h"

namespace bipot {
namespace {

constexpr double kNoCompliance = 1e-12;  // of the largest eigenvalue of a block

}  // namespace

ContactProblem with_compliance(ContactProblem p, const SparseRows& R) {
  if (p.equality) throw std::invalid_argument("R does not go with equality rows");
  const int m = p.num_rows(), d = p.dim;
  if (R.rows() != m || R.cols() != m) {
    throw std::invalid_argument(
        fmt::format("R is {0} x {1}, expected {2} x {2}", R.rows(), R.cols(), m));
  }
  Triplets wrenches, masses;
  int dofs = p.num_dofs();
  for (int c = 0; c < p.num_contacts(); ++c) {
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(d, d);
    for (int k = 0; k < d; ++k) {
      for (SparseRows::InnerIterator it(R, c * d + k); it; ++it) {
        const int row = c * d + k, column = static_cast<int>(it.col());
        if (!std::isfinite(it.value()) || (column / d != c && it.value() != 0)) {
          throw std::invalid_argument(
              fmt::format("R({}, {}) = {}, expected {}", row, column, it.value(),
                          column / d == c ? "a finite number" : "0 between two contacts"));
        }
        if (column / d == c) block(k, column - c * d) = it.value();
      }
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(0.5 * (block + block.transpose()));
    const double largest = parts.eigenvalues().cwiseAbs().maxCoeff();
    if ((block - block.transpose()).cwiseAbs().maxCoeff() > kNoCompliance * largest ||
        parts.eigenvalues()[0] < -kNoCompliance * largest) {
      throw std::invalid_argument(fmt::format(
          "R of contact {} is not symmetric and positive semidefinite (smallest eigenvalue {})", c,
          parts.eigenvalues()[0]));
    }
    for (int k = 0; k < d; ++k) {
      const double value = parts.eigenvalues()[k];
      if (!(value > kNoCompliance * largest)) continue;
      for (int row = 0; row < d; ++row) {
        const double entry = std::sqrt(value) * parts.eigenvectors()(row, k);
        if (entry != 0) wrenches.emplace_back(dofs, c * d + row, entry);
      }
      masses.emplace_back(dofs, dofs, 1.0);
      ++dofs;
    }
  }
  if (p.has_delassus()) p.W = SparseRows(p.W + R);
  if (!p.has_velocities()) return p;
  enlarge(p.A, dofs, dofs, masses);
  enlarge(p.H, dofs, m, wrenches);
  const Vector free = p.v_free;
  p.v_free = Vector::Zero(dofs);
  p.v_free.head(free.size()) = free;
  return p;
}

}  // namespace bipot
