#pragma once

#include "core/base/types.h"

namespace bipot {

/// Parts of disks and spheres within simple regions, in closed form: exact but for rounding, about
/// 1e-15 of the whole. Ends of rectangles and boxes may be infinite.

/// Area of the disk about x that lies in the box.               [m²]
double part_in_box(const Vec2& x, double radius, const Box<2>& box);

/// Area common to two disks whose centres are `distance` apart. [m²]
double area_in_disk(double distance, double radius, double other_radius);

/// Volume of the sphere about x that lies in the box.                  [m³]
double part_in_box(const Vec3& x, double radius, const Box<3>& box);

}  // namespace bipot
