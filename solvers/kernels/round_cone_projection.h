#pragma once

#include "core/base/types.h"
#include "core/problem/coulomb_cone.h"

namespace bipot {

/// The point z of Coulomb's cone in space, |z_t| <= mu z_n, that is nearest to r in the metric M:
/// the least ½ (z - r)·M (z - r), M symmetric positive definite. It is r in the cone, and the tip
/// where M r lies in the polar cone. Else it lies on the edge whose multiplier M (r - z) points
/// outward: of all edges there is one. In the Euclidean metric it is project_coulomb_cone(). [ours]
Local<3> project_round_cone(const Eigen::Matrix3d& metric, double mu, const Local<3>& r);

}  // namespace bipot
