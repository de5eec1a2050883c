#pragma once

#include "core/motion/midpoint.h"

namespace bipot {

/// Velocities after the step, then positions: q <- q_m + h/2 v⁺ (43). `v`: after the step, in the
/// degrees of freedom of the problem; whoever has none there goes on without contact impulses.
/// Disks, clusters, walls and cell of the state are set; takes the disks of the middle.
template <int D>
State<D> update_bodies(Midpoint<D>& mid, const DofMap& dofs, const Vector& v, double h);

}  // namespace bipot
