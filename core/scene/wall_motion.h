#pragma once

#include <type_traits>
#include <vector>

#include "core/scene/scene.h"

namespace bipot {

/// True if the motion or presence of the wall depends on the time.
template <int D>
bool has_schedule(const Wall<D>& wall) {
  return wall.starts > 0 || wall.stops < kInfinity || wall.removed < kInfinity ||
         !wall.time_factor.constant();
}

/// The walls at a given time: those of the scene, with positions and speeds of `now`. A wall that
/// has not started or has stopped is fixed and has no velocity. A removed wall is not present.
/// Walls without a schedule are those of `now`, bit for bit. `span`: time factors are their means
/// over it, about that time; a wall that moves by its velocity is then where it should be.
template <int D>
std::vector<Wall<D>> walls_at(const std::vector<Wall<D>>& scene_walls,
                              const std::vector<Wall<D>>& now, double time, double span = 0);

/// Angle by which a wall of the scene has turned about its axis from time 0 on.             [rad]
template <int D>
double turned_angle(const Wall<D>& scene_wall, double time) {
  const double from = scene_wall.starts, to = std::min(time, scene_wall.stops);
  if (!(to > from)) return 0;
  return scene_wall.spin * scene_wall.time_factor.mean(from, to) * (to - from);
}

/// Velocity of a driven wall with `speed` along its direction. [m/s]
template <int D>
Vec<D> driven_velocity(const Wall<D>& wall, double speed) {
  Vec<D> v = speed * wall.direction;
  if (!wall.across.isZero(0)) v += wall.across;
  return v;
}

/// Speed of a driven wall along its direction.                                               [m/s]
template <int D>
double driven_speed(const Wall<D>& wall) {
  return (wall.v - wall.across).dot(wall.direction);
}

/// Kinetic energy and momentum of the wall itself: those of a driven wall along its direction. Any
/// other motion belongs to the machine that moves the wall.
template <int D>
double wall_kinetic_energy(const Wall<D>& wall) {
  if (wall.motion != Wall<D>::Motion::kDriven) return 0;
  return 0.5 * wall.mass * (wall.v - wall.across).squaredNorm();
}
template <int D>
Vec<D> wall_momentum(const Wall<D>& wall) {
  if (wall.motion != Wall<D>::Motion::kDriven) return Vec<D>::Zero();
  return wall.mass * (wall.v - wall.across);
}

/// Velocity of the wall's surface at a contact with normal n from the wall to the disk. The wall as
/// a whole moves with v; the surface velocity is v, plus rotation for circles, plus that of a belt. [m/s]
template <int D>
Vec<D> surface_velocity(const Wall<D>& wall, const std::type_identity_t<Vec<D>>& v,
                        const std::type_identity_t<Vec<D>>& n);
/// The part of it that no force changes: all but the speed of a driven wall along its direction.
template <int D>
Vec<D> prescribed_velocity(const Wall<D>& wall, const std::type_identity_t<Vec<D>>& n) {
  return surface_velocity(wall, wall.motion == Wall<D>::Motion::kDriven ? wall.across : wall.v, n);
}

}  // namespace bipot
