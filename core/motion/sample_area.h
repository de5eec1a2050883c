#pragma once

#include "core/motion/state.h"

namespace bipot {

/// Area of the sample, for the mean stress, at mid-step. 0 without disks. The first of these that
/// applies: the area enclosed by half-planes, if it contains the disks; a hollow circle around
/// them, less the solid circles in it; in a periodic scene the cell, as high as half-planes allow
/// if y is not periodic; the convex hull of the disks (their rims as polygons of 256 points). [m²]
double sample_measure(const State<2>& state, double step);

}  // namespace bipot
