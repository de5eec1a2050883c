#pragma once

#include <vector>

#include "core/motion/state.h"

namespace bipot {

/// A convex body with flat faces, each a polygon of corners in order around it.
class ConvexBody {
 public:
  /// The box between two corners.
  ConvexBody(const Vec3& lower, const Vec3& upper);
  /// Leaves what lies in front of the plane through `point` with unit normal `normal`.
  void clip(const Vec3& point, const Vec3& normal);
  double volume() const;
  const std::vector<std::vector<Vec3>>& faces() const { return faces_; }

 private:
  std::vector<std::vector<Vec3>> faces_;
};

/// Leaves what lies in a prism of 64 sides with the cylinder's axis, through `point`, and cross-section: exact where planes
/// close it across the axis.
void clip_by_cylinder(ConvexBody& body, const Vec3& point, const Wall<3>& wall);

/// Volume of the sample, for the mean stress: what the walls enclose (half-spaces, hollow cylinders),
/// where they do and the spheres lie in it; else what the planes that touch the sample from 256
/// sides enclose, 1 to 4 % more than its convex hull where that is round. At mid-step. 0 without
/// spheres.                                                                               [m³]
double sample_measure(const State<3>& state, double step);

}  // namespace bipot
