#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <cstddef>
#include <limits>

namespace bipot {

using Vector = Eigen::VectorXd;
using Vec2 = Eigen::Vector2d;
/// Column-major: a column of H is one contact direction.
using SparseMatrix = Eigen::SparseMatrix<double>;
/// Row-major: a row of W is one equation of a sweep.
using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();  ///< undefined
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A number or index that is not negative, as the standard containers count.
template <class Integer>
constexpr std::size_t to_size(Integer k) {
  return static_cast<std::size_t>(k);
}

}  // namespace bipot
