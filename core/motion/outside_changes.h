#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/motion/state.h"
#include "core/scene/scene.h"

namespace bipot {

/// External changes of a scene in a step, besides gravity and walls that move: walls start, stop and
/// are removed, gravity turns, forces and drag act on bodies.
template <int D>
struct OutsideChanges {
  double work = 0;                  ///< [J]
  Vec<D> impulse = Vec<D>::Zero();  ///< on disks and driven walls                       [N s]
};

/// `before`: the state before the step. `walls`: those in the step, with their speeds before it
/// (walls_at). `gravity`: that of the step. `v_free`: of the bodies, if forces act on them. `after`:
/// the state after it.
///
/// Turning gravity from g to g' with fixed disks is work Σ m (g - g')·x, as is turning the box the
/// other way. The potential energy of a state uses gravity at its time, the step that of its
/// middle. Therefore gravity turns at both ends of a step.
template <int D>
OutsideChanges<D> outside_changes(const Scene<D>& scene, const State<D>& before,
                                  const std::vector<Wall<D>>& walls,
                                  const std::type_identity_t<Vec<D>>& gravity,
                                  std::span<const std::type_identity_t<Vec<D>>> v_free,
                                  const State<D>& after);

}  // namespace bipot
