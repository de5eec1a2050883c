#pragma once

#include "core/motion/time_stepping.h"

namespace bipot {

/// Upper bound of the energy that contacts may exchange in a step because gravity acts within it: ½
/// κ |s·f| of data/manual/explanation/method.md §3 with κ <= 1. f = h g at walls at rest, and 0
/// between disks, which fall alike. [J]
template <int D>
double force_energy(const Scene<D>& scene, const StepReport<D>& report) {
  return 0.5 * scene.step * scene.gravity.norm() * report.wall_pushes;
}

}  // namespace bipot
