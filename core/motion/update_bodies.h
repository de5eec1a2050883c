#pragma once

#include "core/motion/midpoint.h"

namespace bipot {

/// Velocities after the step, then positions: q <- q_m + h/2 v⁺ (43). `v`: velocities after the
/// step in the degrees of freedom of the problem; bodies without any continue without contact
/// impulses. Sets disks, clusters, walls and cell of the state; moves the disks out of `mid`.
template <int D>
State<D> update_bodies(Midpoint<D>& mid, const DofMap& dofs, const Vector& v, double h);

}  // namespace bipot
