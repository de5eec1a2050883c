#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/types.h"
#include "solvers/kernels/contact_scaling.h"

namespace bipot {

// Anderson acceleration of solvers/methods/anderson.h, written once for a problem on one process and
// for one that lies on several: `Products` are norms and products of vectors over all rows.

/// The last differences of residuals f and of values g, and the products of the former with each
/// other: the least squares of Anderson acceleration by normal equations, of columns of length 1.
/// (QR as in Walker and Ni 2011, section 4, takes three times as long; what it keeps of a nearly
/// dependent column helps nobody.)
template <class Products>
class AndersonMemory {
 public:
  AndersonMemory(Products products, Eigen::Index rows, int columns)
      : products_(products), df_(rows, columns), dg_(rows, columns), gram_(columns, columns) {}

  void clear() { size_ = newest_ = 0; }

  /// In place of the oldest where all columns are taken.
  void append(const Vector& df, const Vector& dg) {
    const int columns = static_cast<int>(df_.cols());
    newest_ = size_ == 0 ? 0 : (newest_ + 1) % columns;
    size_ = std::min(size_ + 1, columns);
    df_.col(newest_) = df;
    dg_.col(newest_) = dg;
    gram_.col(newest_).head(written()) = products_.products(df_, written(), df);
    gram_.row(newest_).head(written()) = gram_.col(newest_).head(written()).transpose();
  }

  /// x = g - ΔG argmin ‖f - ΔF gamma‖, over the newest columns that are independent.
  void combine(const Vector& f, const Vector& g, Vector& x) {
    x = g;
    if (size_ == 0) return;
    const int columns = static_cast<int>(df_.cols());
    const Vector products = products_.products(df_, written(), f);
    // Cholesky, newest first.
    Eigen::MatrixXd l(size_, size_);
    Vector y(size_), unit(size_);
    std::vector<int> at(to_size(size_));
    int rank = 0;
    for (; rank < size_; ++rank) {
      const int column = (newest_ - rank + columns) % columns;
      const double length = std::sqrt(gram_(column, column));
      if (!(length > 0)) break;
      unit[rank] = 1 / length;
      at[to_size(rank)] = column;
      for (int k = 0; k < rank; ++k) {
        l(rank, k) = (gram_(column, at[to_size(k)]) * unit[rank] * unit[k] -
                      l.row(rank).head(k).dot(l.row(k).head(k))) /
                     l(k, k);
      }
      const double pivot = 1 - l.row(rank).head(rank).squaredNorm();
      if (!(pivot > kSmallestPivot)) break;
      l(rank, rank) = std::sqrt(pivot);
      y[rank] = (products[column] * unit[rank] - l.row(rank).head(rank).dot(y.head(rank))) /
                l(rank, rank);
    }
    size_ = rank;  // the others, all older, are not worth their time
    const auto lower = l.topLeftCorner(rank, rank).template triangularView<Eigen::Lower>();
    const Vector gamma = lower.transpose().solve(y.head(rank)).cwiseProduct(unit.head(rank));
    for (int k = 0; k < rank; ++k) x -= gamma[k] * dg_.col(at[to_size(k)]);
  }

 private:
  static constexpr double kSmallestPivot = 1e-10;  // square of a column's part that is new

  /// The first columns of the rings, up to the last one in use.
  int written() const { return newest_ + 1 >= size_ ? newest_ + 1 : static_cast<int>(df_.cols()); }

  Products products_;
  Eigen::MatrixXd df_, dg_, gram_;  // rings
  int size_ = 0, newest_ = 0;
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
