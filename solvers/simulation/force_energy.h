#pragma once

#include "core/motion/time_stepping.h"

namespace bipot {

/// The most energy that contacts may hand on in a step because gravity acts within it, ½ κ |s·f| of
/// data/manual/explanation/method.md §3 with κ <= 1: f = h g at walls that stand, and 0 between
/// disks, which fall alike.                                                              [J]
template <int D>
double force_energy(const Scene<D>& scene, const StepReport<D>& report) {
  return 0.5 * scene.step * scene.gravity.norm() * report.wall_pushes;
}

}  // namespace bipot
