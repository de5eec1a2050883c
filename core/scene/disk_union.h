#pragma once

#include <span>

#include "core/base/types.h"

namespace bipot {

/// Zeroth, first and second moment of the union of disks: overlaps count once.
struct UnionMoments {
  double area = 0;             ///< [m²]
  Vec2 centre = Vec2::Zero();  ///< centre of area                                [m]
  double polar = 0;            ///< ∫ |x - centre|² dA                             [m⁴]
};

struct Circle {
  Vec2 centre = Vec2::Zero();  ///< [m]
  double radius = 0;           ///< > 0                                              [m]
};

/// Exact but for rounding, for any number of disks: apart, overlapping, nested, with holes. Green's
/// theorem turns each integral into one along the border of the union. The border consists of the
/// arcs that no other disk covers, each counter-clockwise about its own centre.
UnionMoments union_moments(std::span<const Circle> circles);

/// Area of the union within the rectangle from low to high, whose ends may be infinite. The border
/// consists of the arcs in the rectangle and the parts of its sides in the union. [m²]
double union_area_in(std::span<const Circle> circles, const Vec2& low, const Vec2& high);

}  // namespace bipot
