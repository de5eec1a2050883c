#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/base/types.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/solve_run.h"

namespace bipot {

// Anderson acceleration of solvers/methods/anderson.h for one process and in parallel. `Products`
// are norms and products of vectors over all rows.

/// The last differences of residuals f and of values g, with the mutual products of the former. The
/// least squares of Anderson acceleration are solved by normal equations, for columns of length 1.
/// [ours] Walker and Ni (2011, section 4) keep a QR factorisation, which reads all columns three
/// times as often.
template <class Products>
class AndersonMemory {
 public:
  /// Keeps a reference to `products`.
  AndersonMemory(Products& products, Eigen::Index rows, int columns)
      : products_(products),
        df_(rows, columns),
        dg_(rows, columns),
        gram_(columns, columns),
        factor_(columns, columns),
        right_(columns),
        unit_(columns),
        at_(to_size(columns)) {}

  void clear() { size_ = newest_ = 0; }

  /// Adds a column; replaces the oldest if all are used.
  void append(const Vector& df, const Vector& dg) {
    const int columns = static_cast<int>(df_.cols());
    newest_ = size_ == 0 ? 0 : (newest_ + 1) % columns;
    size_ = std::min(size_ + 1, columns);
    df_.col(newest_) = df;
    dg_.col(newest_) = dg;
    const Vector products = products_.products(df_, written(), df);
    gram_.col(newest_).head(written()) = products;
    gram_.row(newest_).head(written()) = products.transpose();
  }

  /// x = g - ΔG argmin ‖f - ΔF gamma‖, over the newest columns that are independent.
  void combine(const Vector& f, const Vector& g, Vector& x) {
    x = g;
    if (size_ == 0) return;
    const int columns = static_cast<int>(df_.cols());
    const Vector products = products_.products(df_, written(), f);
    // Cholesky, newest first.
    int rank = 0;
    for (; rank < size_; ++rank) {
      const int column = (newest_ - rank + columns) % columns;
      const double length = std::sqrt(gram_(column, column));
      if (!(length > 0)) break;
      unit_[rank] = 1 / length;
      at_[to_size(rank)] = column;
      const auto row = factor_.row(rank);
      for (int k = 0; k < rank; ++k) {
        factor_(rank, k) = (gram_(column, at_[to_size(k)]) * unit_[rank] * unit_[k] -
                            row.head(k).dot(factor_.row(k).head(k))) /
                           factor_(k, k);
      }
      const double pivot = 1 - row.head(rank).squaredNorm();
      if (!(pivot > kSmallestPivot)) break;
      factor_(rank, rank) = std::sqrt(pivot);
      right_[rank] = (products[column] * unit_[rank] - row.head(rank).dot(right_.head(rank))) /
                     factor_(rank, rank);
    }
    size_ = rank;  // the others are older and dependent
    factor_.topLeftCorner(rank, rank)
        .template triangularView<Eigen::Lower>()
        .transpose()
        .solveInPlace(right_.head(rank));
    for (int k = 0; k < rank; ++k) x -= right_[k] * unit_[k] * dg_.col(at_[to_size(k)]);
  }

 private:
  static constexpr double kSmallestPivot = 1e-10;  // square of a column's part that is new

  /// The first columns of the ring buffers, up to the last one in use.
  int written() const { return newest_ + 1 >= size_ ? newest_ + 1 : static_cast<int>(df_.cols()); }

  Products& products_;
  Eigen::MatrixXd df_, dg_, gram_;  // rings
  Eigen::MatrixXd factor_;          // scratch of combine()
  Vector right_, unit_;
  std::vector<int> at_;
  int size_ = 0, newest_ = 0;
};

/// map: s -> G(s), in the problem's variables.
inline void iterate_anderson(SolveRun& run, const ContactScaling& scaling, int columns,
                             const std::function<void(Vector&)>& map) {
  constexpr double kLargestGrowth = 2;  // of the residual, over the smallest one accepted
  Vector s = run.start();
  AndersonMemory<ContactSpace> memory(run.space(), s.size(), columns);
  Vector x = scaling.impulse.cwiseProduct(s), g(x.size()), f(x.size());
  Vector f_before, g_before;
  double smallest = kInfinity;
  bool accelerated = false;
  bool known_before =
      false;  // not by sizes: a process without rows must still take part in all sums
  for (int iteration = 0; !run.stop(iteration, s); ++iteration) {
    s = x.cwiseProduct(scaling.velocity);
    map(s);
    g = scaling.impulse.cwiseProduct(s);
    f = g - x;
    const double residual = run.space().norm(f);
    if (accelerated && !(residual <= kLargestGrowth * smallest)) {
      memory.clear();
      x = g_before;
      accelerated = false;
      known_before = false;
      smallest = kInfinity;
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
