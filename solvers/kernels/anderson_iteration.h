#pragma once

#include <Eigen/Jacobi>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/types.h"
#include "solvers/kernels/contact_scaling.h"

namespace bipot {

// Anderson acceleration of solvers/methods/anderson.h, written once for a problem on one process and
// for one that lies on several: `Products` are norms and products of vectors over all rows.

/// The last differences of residuals f and values g, with ΔF = Q R kept up to date column by
/// column (Walker and Ni 2011, section 4).
template <class Products>
class AndersonMemory {
 public:
  AndersonMemory(Products products, Eigen::Index rows, int columns)
      : products_(products),
        q_(rows, columns),
        g_(rows, columns),
        r_(Eigen::MatrixXd::Zero(columns, columns)) {}

  void clear() { size_ = 0; }

  void append(const Vector& df, const Vector& dg) {
    if (size_ == static_cast<int>(q_.cols())) drop_oldest();
    auto column = q_.col(size_);
    column = df;
    for (int k = 0; k < size_; ++k) r_(k, size_) = 0;
    products_.project_out(q_, size_, column, r_);
    const double norm = products_.norm(column);
    if (!(norm > 0)) return;  // nothing new
    column /= norm;
    r_(size_, size_) = norm;
    g_.col((first_ + size_) % g_.cols()) = dg;
    ++size_;
    while (size_ > 1 && badly_conditioned()) drop_oldest();
  }

  /// g - ΔG argmin ‖f - ΔF gamma‖.
  void combine(const Vector& f, const Vector& g, Vector& x) const {
    x = g;
    if (size_ == 0) return;
    Vector gamma = products_.products(q_, size_, f);
    r_.topLeftCorner(size_, size_).triangularView<Eigen::Upper>().solveInPlace(gamma);
    for (int k = 0; k < size_; ++k) x -= gamma[k] * g_.col((first_ + k) % g_.cols());
  }

 private:
  bool badly_conditioned() const {
    const auto pivots = r_.diagonal().head(size_).cwiseAbs();
    return pivots.minCoeff() < kSmallestPivot * pivots.maxCoeff();
  }
  void drop_oldest() {
    // Without its first column R is upper Hessenberg; rotations make it triangular again.
    for (int k = 0; k + 1 < size_; ++k) {
      for (int row = 0; row <= k + 1; ++row) r_(row, k) = r_(row, k + 1);
      for (int row = k + 2; row < size_; ++row) r_(row, k) = 0;
    }
    for (int k = 0; k + 1 < size_; ++k) {
      Eigen::JacobiRotation<double> rotation;
      rotation.makeGivens(r_(k, k), r_(k + 1, k));
      r_.leftCols(size_ - 1).applyOnTheLeft(k, k + 1, rotation.adjoint());
      q_.applyOnTheRight(k, k + 1, rotation);
    }
    first_ = (first_ + 1) % static_cast<int>(g_.cols());
    --size_;
  }

  static constexpr double kSmallestPivot = 1e-8;  // of the triangular factor, relative

  Products products_;
  Eigen::MatrixXd q_, g_, r_;  // g_ is a ring that begins at first_
  int size_ = 0, first_ = 0;
};

/// map: s -> G(s), in the problem's variables.
template <class Products, class Monitor>
void iterate_anderson(Products products, const ContactScaling& scaling, const Vector& s0,
                      int columns, Monitor& monitor, const std::function<void(Vector&)>& map) {
  constexpr double kLargestGrowth = 2;  // of the residual, over the smallest one accepted
  AndersonMemory<Products> memory(products, s0.size(), columns);
  Vector x = scaling.impulse.cwiseProduct(s0), s = s0, g(x.size()), f(x.size());
  Vector f_before, g_before;
  double smallest = std::numeric_limits<double>::infinity();
  bool accelerated = false;
  bool known_before =
      false;  // not by sizes: a process may have no rows, and takes part in all sums
  for (int iteration = 0; !monitor.stop(iteration, s); ++iteration) {
    s = x.cwiseProduct(scaling.velocity);
    map(s);
    g = scaling.impulse.cwiseProduct(s);
    f = g - x;
    const double residual = products.norm(f);
    if (accelerated && !(residual <= kLargestGrowth * smallest)) {
      memory.clear();
      x = g_before;
      accelerated = false;
      known_before = false;
      smallest = std::numeric_limits<double>::infinity();
      continue;
    }
    smallest = std::min(smallest, residual);
    if (known_before) memory.append(f - f_before, g - g_before);
    f_before = f;
    g_before = g;
    known_before = true;
    memory.combine(f, g, x);
    accelerated = true;
  }
}

}  // namespace bipot
