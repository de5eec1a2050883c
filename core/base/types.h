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

}  // namespace bipot
