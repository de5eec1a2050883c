#pragma once

#include <string>

#include "core/motion/time_stepping.h"

namespace bipot {

/// What it took to part the bodies of a scene.
struct PushApart {
  int rounds = 0;
  double way = 0;       ///< largest displacement of a body                             [m]
  double radii = 0;     ///< the same over the body's radius, the largest of the bodies
  std::string message;  ///< why overlaps remain, if the solver said so
};

/// Moves the bodies of a scene until nothing overlaps at the start, by rounds of the smallest
/// displacement in the energy norm (core/motion/projection.h), without velocities; a round takes no
/// more than the largest radius off an overlap. All walls stay. It ends after 200 rounds, or where
/// a round is not solved: start_overlaps() then still finds overlaps.
/// Outlets do not count. `solver` solves problems without friction. Not for cells and clusters.
template <int D>
PushApart push_apart(Scene<D>& scene, const StepSolver& solver, int threads = 1);

}  // namespace bipot
