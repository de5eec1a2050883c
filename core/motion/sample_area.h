#pragma once

#include "core/motion/state.h"

namespace bipot {

/// Area of the sample, for the mean stress: what half-planes enclose, where they do and the disks
/// lie in it; else a hollow circle that holds them, less the solid circles in it; of a periodic
/// scene its cell, as high as half-planes leave room where y is not periodic; else the convex hull
/// of the disks (their rims as polygons of 256 points). At mid-step. 0 without disks.        [m²]
double sample_measure(const State<2>& state, double step);

}  // namespace bipot
