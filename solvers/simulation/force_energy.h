#pragma once

#include "core/motion/state.h"

namespace bipot {

/// The most energy that contacts may hand on in a step because gravity acts within it, ½ κ |s·f| of
/// data/manual/explanation/method.md §3 with κ <= 1: f = h g at walls that stand, and 0 between disks, which fall
/// alike. `after`: the state after the step.
/// [J]
template <int D>
double force_energy(const Scene<D>& scene, const State<D>& after);
/// The same from what walls pushed with in the step, Σ |s| over their contacts        [N s].
template <int D>
double force_energy(const Scene<D>& scene, double wall_pushes);

}  // namespace bipot
