#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>

#include "core/scene/scene.h"

namespace bipot {

// Parts of scenes that programs and tests build, and sizes of bodies.

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

/// The wall moves at this velocity.
template <int D>
void move_at(Wall<D>& wall, const std::type_identity_t<Vec<D>>& v) {
  wall.motion = Wall<D>::Motion::kMoving;
  wall.v = v;
}
/// The wall follows a force [N] along `direction`, a unit vector.
template <int D>
void drive(Wall<D>& wall, const std::type_identity_t<Vec<D>>& direction, double mass,
           double force = 0) {
  wall.motion = Wall<D>::Motion::kDriven;
  wall.direction = direction;
  wall.mass = mass;
  wall.force = force;
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

/// Area [m²] or volume [m³].
inline double extent(const Disk& d) { return std::numbers::pi * d.radius * d.radius; }
inline double extent(const Sphere& s) {
  return 4 * std::numbers::pi / 3 * s.radius * s.radius * s.radius;
}

/// Mass and inertia of a homogeneous body of this density, in 2D kg/m².
inline void give_density(Disk& disk, double density) {
  give_mass(disk, density * std::numbers::pi * disk.radius * disk.radius);
}
inline void give_density(Sphere& sphere, double density) {
  give_mass(sphere, density * 4 / 3 * std::numbers::pi * std::pow(sphere.radius, 3));
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
