#pragma once

#include <cstdint>

#include "core/scene/scene.h"

namespace bipot {

/// Scene `index` of the set `seed`: 1 to 20 disks thrown into a box or on a floor. Radii and masses
/// range over decades, friction up to 1e6, units of mass, length and time between 10^-6 and 10^6,
/// so that accelerations and forces range over more than 20 decades. A third has different
/// coefficients of restitution for normal and tangent, a fifth a wall that moves or is driven.
Scene<2> random_scene(std::uint64_t seed, int index);

/// True if contacts cannot create kinetic energy by theory: one coefficient e for all rows, and
/// walls at rest (data/manual/explanation/method.md §3).
bool contacts_must_dissipate(const Scene<2>& scene);

}  // namespace bipot
