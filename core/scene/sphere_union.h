#pragma once

#include <span>

#include "core/scene/scene.h"

namespace bipot {

// Unions of spheres, whose overlaps count once. Apart, they are sums in closed form. Else planes cut
// the union into unions of disks, with exact moments (core/scene/disk_union.h). The integral over the
// planes is a Gauss rule between the places where a sphere or a circle of two begins or ends.

/// The union as a body of density 1 at rest: its mass is its volume. The inertia follows from the
/// moments about six axes. Relative error: about 1e-9; 1e-5 where three spheres have points in
/// common.
Cluster<3> union_of_spheres(std::span<const Sphere> spheres);

/// Volume of the union within the box from low to high, whose ends may be infinite; relative error
/// about 1e-4 where spheres overlap. [m³]
double union_volume_in(std::span<const Sphere> spheres, const Vec3& low, const Vec3& high);

}  // namespace bipot
