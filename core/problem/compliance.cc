#include "core/problem/compliance.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/base/triplets.h"

namespace bipot {
namespace {

constexpr double kNoCompliance = 1e-12;  // of the largest entry of a block

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
    Eigen::MatrixXd rest = 0.5 * (block + block.transpose());
    const double least = kNoCompliance * rest.cwiseAbs().maxCoeff();
    const bool refused = (block - block.transpose()).cwiseAbs().maxCoeff() > least;
    // R = Lᵀ L by Cholesky's method, the largest pivot first.
    for (int k = 0; k < d && !refused; ++k) {
      int pivot = 0;
      const double value = rest.diagonal().maxCoeff(&pivot);
      if (!(value > least)) break;
      const Vector row = rest.col(pivot) / std::sqrt(value);
      for (int i = 0; i < d; ++i) {
        if (row[i] != 0) wrenches.emplace_back(dofs, c * d + i, row[i]);
      }
      masses.emplace_back(dofs, dofs, 1.0);
      ++dofs;
      rest -= row * row.transpose();
      rest.row(pivot).setZero();
      rest.col(pivot).setZero();
    }
    if (refused || rest.cwiseAbs().maxCoeff() > least) {
      throw std::invalid_argument(
          fmt::format("R of contact {} is not symmetric and positive semidefinite", c));
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
