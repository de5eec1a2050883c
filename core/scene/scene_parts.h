#pragma once

#include <string>
#include <utility>

#include "core/scene/scene.h"

namespace bipot {

// Parts of scenes that programs and tests build.

inline constexpr double kGravity = 9.81;  ///< [m/s²]

/// Solid behind the line or plane through `point`; `normal` is a unit vector.
template <int D>
Wall<D> half_space(const Vec<D>& point, const Vec<D>& normal, std::string name = {}) {
  return Wall<D>{.name = std::move(name), .a = point, .normal = normal};
}

/// Solid below the height 0 of the last axis.
template <int D>
Wall<D> flat_floor() {
  return half_space<D>(Vec<D>::Zero(), Vec<D>::Unit(D - 1), "floor");
}

/// The inertia is that of a homogeneous disk, m a²/2, or sphere, 2/5 m a².
inline void give_mass(Disk& disk, double mass) {
  disk.mass = mass;
  disk.inertia = 0.5 * mass * disk.radius * disk.radius;
}
inline void give_mass(Sphere& sphere, double mass) {
  sphere.mass = mass;
  sphere.inertia = 0.4 * mass * sphere.radius * sphere.radius;
}

/// A homogeneous disk or sphere.
template <int D>
Body<D> round_body(const Vec<D>& x, double radius, double mass, const Vec<D>& v = Vec<D>::Zero(),
                   const decltype(Body<D>::spin)& spin = Body<D>().spin) {
  Body<D> body;
  body.x = x;
  body.v = v;
  body.spin = spin;
  body.radius = radius;
  give_mass(body, mass);
  return body;
}

/// A scene of one material, without bodies, walls and gravity.
template <int D>
Scene<D> one_law(const ContactLaw& law) {
  return Scene<D>{.materials = {"m"}, .laws = {law}};
}

}  // namespace bipot
