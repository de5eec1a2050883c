#pragma once

#include <array>

#include "core/scene/contact_frame.h"
#include "core/scene/scene.h"

namespace bipot {

/// What the rows of a contact measure: u_k = force[k] . (relative velocity), and the impulse on
/// body i is the sum of s_k force[k]. In return, the velocity is the sum of u_k velocity[k], and
/// s_k = velocity[k] . impulse. Both are contact_frame(n), but on a plate with a grain. There t1
/// lies along the grain and force[2] = ratio t2, velocity[2] = t2 / ratio. In these components the
/// ellipse (s_1 / mu)^2 + (s_2 / (ratio mu))^2 <= s_n^2 is Coulomb's round cone, exactly, and
/// slip follows the normal of the ellipse: what friction dissipates is largest (Goyal, Ruina and
/// Papadopoulos, "Planar sliding with dry friction", Wear 143 (1991), p. 307).
template <int D>
struct ContactAxes {
  std::array<Vec<D>, to_size(D)> force, velocity;
};

/// The axes of a contact with normal n. `wall`: that the body touches, or null. Where n lies along
/// the grain (on an edge of a polygon) the axes are those of contact_frame.
template <int D>
ContactAxes<D> contact_axes(const Vec<D>& n, const Wall<D>* wall) {
  ContactAxes<D> axes{contact_frame<D>(n), {}};
  axes.velocity = axes.force;
  if constexpr (D == 3) {
    if (wall == nullptr || !wall->has_grain()) return axes;
    const Vec3 along = wall->grain - wall->grain.dot(n) * n;
    if (!(along.norm() > 1e-9)) return axes;
    const Vec3 t1 = along.normalized(), t2 = n.cross(t1);
    axes.force = {n, t1, wall->grain_ratio * t2};
    axes.velocity = {n, t1, t2 / wall->grain_ratio};
  }
  return axes;
}

}  // namespace bipot
