#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/scene/scene.h"

namespace bipot {

/// True if forces on bodies or drag act in the scene.
template <int D>
bool has_body_forces(const Scene<D>& scene) {
  return !scene.forces.empty() || scene.drag.coefficient > 0;
}

/// Adds forces on bodies and drag to velocities without contacts. `v_free`: v + h g of each body.
/// Forces are means over the step around `middle` [s]. Drag acts exactly on velocities: with k =
/// coefficient × radius / mass, the other accelerations a and the fluid's velocity w, in a cell that
/// deforms with its homogeneous velocity in addition,
///
///     v_free = w + (v - w) exp(-k h) + a (1 - exp(-k h))/k.
template <int D>
void add_body_forces(const Scene<D>& scene, const PeriodicCell& cell, double middle,
                     std::span<const std::type_identity_t<Body<D>>> bodies,
                     std::vector<Vec<D>>& v_free);

/// Adds their accelerations at a time [s] to those of the bodies.
template <int D>
void add_force_accelerations(const Scene<D>& scene, const PeriodicCell& cell, double time,
                             std::span<const std::type_identity_t<Body<D>>> bodies,
                             std::vector<Vec<D>>& a);

}  // namespace bipot
