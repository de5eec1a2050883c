#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "core/base/types.h"

namespace bipot {

/// A tangential quantity of a contact (an impulse, a velocity). In 2D: its component along t = e3 x
/// n. In 3D: the whole vector, orthogonal to n, since no tangent is special.
template <int D>
using Tangent = std::conditional_t<D == 2, double, Vec3>;

/// The local frame of a contact with unit normal n, right-handed. In 2D: (n, t), t = e3 x n. In 3D:
/// (n, t1, t2), t2 = n x t1. There t1 is that of Duff et al., "Building an Orthonormal Basis,
/// Revisited", Journal of Computer Graphics Techniques 6 (2017), p. 1: no branch, orthonormal to
/// rounding everywhere. It jumps where n_z changes its sign. Therefore components along t1 and t2
/// must not be carried from step to step.
template <int D>
std::array<Vec<D>, to_size(D)> contact_frame(const Vec<D>& n) {
  if constexpr (D == 2) {
    return {n, Vec2(-n[1], n[0])};
  } else {
    const double sign = std::copysign(1.0, n[2]);
    const double a = -1 / (sign + n[2]);
    const double b = n[0] * n[1] * a;
    return {n, Vec3(1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]),
            Vec3(b, sign + n[1] * n[1] * a, -n[1])};
  }
}

/// A tangential impulse or velocity as a vector.
inline Vec2 tangent_vector(const Vec2& n, double along) { return along * Vec2(-n[1], n[0]); }
inline Vec3 tangent_vector(const Vec3& /*n*/, const Vec3& vector) { return vector; }

inline double magnitude(double x) { return std::abs(x); }
inline double magnitude(const Vec3& x) { return x.norm(); }

/// n x t of a tangential vector: the moment of a force at the arm n.
inline double turning(const Vec2& /*n*/, double along) { return along; }
inline Vec3 turning(const Vec3& n, const Vec3& vector) { return n.cross(vector); }

/// Velocity of a point at the arm of a body that turns.
inline Vec2 swept(double spin, const Vec2& arm) { return spin * Vec2(-arm[1], arm[0]); }
inline Vec3 swept(const Vec3& spin, const Vec3& arm) { return spin.cross(arm); }

/// arm × x: the moment of a force at an arm.
inline double arm_times(const Vec2& arm, const Vec2& x) { return arm[0] * x[1] - arm[1] * x[0]; }
inline Vec3 arm_times(const Vec3& arm, const Vec3& x) { return arm.cross(x); }

inline double inner(double a, double b) { return a * b; }
inline double inner(const Vec3& a, const Vec3& b) { return a.dot(b); }

/// The matrix of w × (in 2D w e3 ×, a quarter turn counter-clockwise).
inline Mat<2> cross_matrix(double w) { return (Mat<2>() << 0, -w, w, 0).finished(); }
inline Mat<3> cross_matrix(const Vec3& w) {
  return (Mat<3>() << 0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0).finished();
}

/// Zero of a Spin or Tangent.
template <int D>
Spin<D> no_turn() {
  if constexpr (D == 2) {
    return 0.0;
  } else {
    return Vec3::Zero();
  }
}

}  // namespace bipot
