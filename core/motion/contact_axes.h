#pragma once

#include <array>

#include "core/scene/contact_frame.h"
#include "core/scene/scene.h"

namespace bipot {

/// The axes of a contact's rows: u_k = axis k . (relative velocity), and the impulse on body i is
/// the sum of s_k times axis k. `wall`: that the body touches, or null. They are contact_frame(n),
/// but on a plate with a grain t1 lies along it, and t2 is times the ratio of friction across the
/// grain to that along it. In these components the ellipse (s_1 / mu)^2 + (s_2 / (ratio mu))^2 <=
/// s_n^2 is Coulomb's round cone, exactly, and slip follows the normal of the ellipse: what friction
/// dissipates is largest (Goyal, Ruina and Papadopoulos, "Planar sliding with dry friction", Wear 143
/// (1991), p. 307). Where n lies along the grain, on an edge of a polygon, nothing is scaled.
template <int D>
std::array<Vec<D>, to_size(D)> contact_axes(const Vec<D>& n, const Wall<D>* wall) {
  if constexpr (D == 3) {
    if (wall != nullptr && wall->has_grain()) {
      const Vec3 along = wall->grain - wall->grain.dot(n) * n;
      if (along.norm() > 1e-9) {
        const Vec3 t1 = along.normalized();
        return {n, t1, wall->grain_ratio * n.cross(t1)};
      }
    }
  }
  return contact_frame<D>(n);
}

/// The way back: the velocity is the sum of u_k times axis k, and s_k = axis k . impulse.
template <int D>
std::array<Vec<D>, to_size(D)> dual_axes(const Vec<D>& n, const Wall<D>* wall) {
  auto axes = contact_axes<D>(n, wall);
  if constexpr (D == 3) {
    if (wall != nullptr && wall->has_grain()) axes[2] /= axes[2].squaredNorm();
  }
  return axes;
}

}  // namespace bipot
