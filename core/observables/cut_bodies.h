#pragma once

#include "core/base/types.h"

namespace bipot {

/// Parts of disks and spheres within simple regions, in closed form: exact but for rounding, about
/// 1e-15 of the whole. Ends of rectangles and boxes may be infinite.

/// Area of the disk about x that lies in the rectangle from low to high.               [m²]
double area_in_rectangle(const Vec2& x, double radius, const Vec2& low, const Vec2& high);

/// Area common to two disks whose centres are `distance` apart. [m²]
double area_in_disk(double distance, double radius, double other_radius);

/// Volume of the sphere about x that lies in the box from low to high.                  [m³]
double volume_in_box(const Vec3& x, double radius, const Vec3& low, const Vec3& high);

/// Area or volume in a box along the axes.
inline double part_in_box(const Vec2& x, double radius, const Vec2& low, const Vec2& high) {
  return area_in_rectangle(x, radius, low, high);
}
inline double part_in_box(const Vec3& x, double radius, const Vec3& low, const Vec3& high) {
  return volume_in_box(x, radius, low, high);
}

}  // namespace bipot
