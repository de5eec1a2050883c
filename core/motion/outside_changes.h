#pragma once

#include <type_traits>
#include <vector>

#include "core/motion/state.h"
#include "core/scene/scene.h"

namespace bipot {

/// What the outside does to a scene in a step besides forces and walls that move: walls start, stop
/// and are removed, gravity turns.
template <int D>
struct OutsideChanges {
  double work = 0;                  ///< [J]
  Vec<D> impulse = Vec<D>::Zero();  ///< on disks and driven walls                       [N s]
};

/// `before`: the state before the step; `walls`: as they are in the step, with their speeds before
/// it (walls_at); `gravity`: of the step; `after`: where the bodies are after it; `time`: then.
///
/// Turning gravity from g to g' with the disks in their places is work Σ m (g - g')·x: what turning the
/// box the other way would take. The potential energy of a state is that of gravity at its time,
/// the step's gravity that of its middle, so it turns at both ends of a step.
template <int D>
OutsideChanges<D> outside_changes(const Scene<D>& scene, const State<D>& before,
                                  const std::vector<Wall<D>>& walls,
                                  const std::type_identity_t<Vec<D>>& gravity,
                                  const State<D>& after, double time);

}  // namespace bipot
