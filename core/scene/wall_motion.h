#pragma once

#include <type_traits>
#include <vector>

#include "core/scene/scene.h"

namespace bipot {

/// True where the wall's motion or presence depends on the time.
template <int D>
bool has_schedule(const Wall<D>& wall) {
  return wall.starts > 0 || wall.stops < kInfinity || wall.removed < kInfinity;
}

/// What the walls are at a time: the scene's, in the places and with the speeds of `now`. A wall
/// that has not started or has stopped is fixed and has no velocity; one that has been removed is
/// not present. Walls without a schedule are those of `now`, bit for bit.
template <int D>
std::vector<Wall<D>> walls_at(const std::vector<Wall<D>>& scene_walls,
                              const std::vector<Wall<D>>& now, double time);

/// Velocity of a driven wall that moves with `speed` along its direction.                    [m/s]
template <int D>
Vec<D> driven_velocity(const Wall<D>& wall, double speed);

/// Speed of a driven wall along its direction.                                               [m/s]
template <int D>
double driven_speed(const Wall<D>& wall);

/// Kinetic energy and momentum that a wall has of its own: those of a driven wall along its
/// direction. What it is moved by besides belongs to the machine that moves it.
template <int D>
double wall_kinetic_energy(const Wall<D>& wall);
template <int D>
Vec<D> wall_momentum(const Wall<D>& wall);

/// Velocity of the wall's surface at a contact whose normal n points from the wall to the disk,
/// where the wall as a whole moves with v: the same, but for circles that turn.              [m/s]
template <int D>
Vec<D> surface_velocity(const Wall<D>& wall, const std::type_identity_t<Vec<D>>& v,
                        const std::type_identity_t<Vec<D>>& n);
/// The part of it that no force changes: all of it but a driven wall's speed along its direction.
template <int D>
Vec<D> prescribed_velocity(const Wall<D>& wall, const std::type_identity_t<Vec<D>>& n);

}  // namespace bipot
