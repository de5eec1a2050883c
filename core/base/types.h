#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <limits>
#include <type_traits>

namespace bipot {

using Vector = Eigen::VectorXd;
using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
/// A point or a direction in D dimensions, 2 or 3.
template <int D>
using Vec = Eigen::Matrix<double, D, 1>;
/// Rotational quantities (spins, moments): a number in 2D, counter-clockwise; a vector in 3D.
template <int D>
using Spin = std::conditional_t<D == 2, double, Vec3>;
template <int D>
using Mat = Eigen::Matrix<double, D, D>;
/// Components of a Spin<D>.
template <int D>
inline constexpr int kSpins = D == 2 ? 1 : 3;
/// Column-major: a column of H is one contact direction.
using SparseMatrix = Eigen::SparseMatrix<double>;
/// Row-major: a row of W is one equation of a sweep.
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();  ///< undefined
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A non-negative number or index in the type of the standard containers.
template <class Integer>
constexpr std::size_t to_size(Integer k) {
  return static_cast<std::size_t>(k);
}

/// Box along the axes; empty (lower > upper) until something is included. [m]
template <int D>
struct Box {
  Vec<D> lower = Vec<D>::Constant(1e300), upper = Vec<D>::Constant(-1e300);

  bool empty() const { return !(lower.array() <= upper.array()).all(); }
  void include(const Vec<D>& x) {
    lower = lower.cwiseMin(x);
    upper = upper.cwiseMax(x);
  }
  /// A round body.
  void include(const Vec<D>& x, double radius) {
    include(x - Vec<D>::Constant(radius));
    include(x + Vec<D>::Constant(radius));
  }
  void widen(double by) {
    lower.array() -= by;
    upper.array() += by;
  }
  /// Lower edges belong to it, upper ones do not.
  bool contains(const Vec<D>& x) const {
    return (x.array() >= lower.array()).all() && (x.array() < upper.array()).all();
  }
  /// The point of it that is nearest to x.
  Vec<D> nearest(const Vec<D>& x) const { return x.cwiseMax(lower).cwiseMin(upper); }
  /// Along the first two axes.
  Box<2> flat() const { return {lower.template head<2>(), upper.template head<2>()}; }
  Vec<D> size() const { return upper - lower; }
  Vec<D> centre() const { return 0.5 * (lower + upper); }
};

}  // namespace bipot
