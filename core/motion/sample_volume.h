#pragma once

#include <vector>

#include "core/motion/state.h"

namespace bipot {

/// A convex body with flat faces, each a polygon with its corners in order.
class ConvexBody {
 public:
  /// The box between two corners.
  ConvexBody(const Vec3& lower, const Vec3& upper);
  /// Keeps the part in front of the plane through `point` with unit normal `normal`.
  void clip(const Vec3& point, const Vec3& normal);
  double volume() const;
  const std::vector<std::vector<Vec3>>& faces() const { return faces_; }

 private:
  std::vector<std::vector<Vec3>> faces_;
};

/// Keeps the part in a prism of 64 sides with the cylinder's axis, through `point`, and the same
/// cross-section: exact if planes close it across the axis.
void clip_by_cylinder(ConvexBody& body, const Vec3& point, const Wall<3>& wall);

/// Volume of the sample, for the mean stress, at mid-step. 0 without spheres. It is the volume
/// enclosed by the walls (half-spaces, hollow cylinders), if that contains the spheres. Else it is
/// about that of the convex hull: planes of 642 directions touch the sample, and the points where
/// they touch span triangles. Exact for one sphere, and within 1 % for a row. [m³]
double sample_measure(const State<3>& state, double step);

}  // namespace bipot
