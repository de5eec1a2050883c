#pragma once

#include <vector>

#include "core/motion/state.h"
#include "core/scene/scene.h"
#include "solvers/simulation/domain_state.h"

namespace bipot {

/// The bodies that one process needs in a step: its own, and copies of others (ghosts).
template <int D>
struct LocalBodies {
  std::vector<int> numbers;  ///< in the whole, ascending
  std::vector<int> owner;    ///< rank, of each
  std::vector<int> own;      ///< places of the own ones, ascending
  State<D> state;            ///< own bodies and ghosts before the step, with the walls
};

/// Adds ghosts: every process learns the box of the others' bodies at mid-step and sends them its
/// bodies within reach. These are the bodies that touch a neighbour of one of their bodies. All
/// contacts of the bodies of an owned contact can then be found locally. A body is within reach if
/// its distance from the box is less than twice the interaction distance and the largest diameter.
/// Ghosts have the bits of their originals. One message to each nearby process. Collective.
template <int D>
LocalBodies<D> with_ghosts(const Scene<D>& scene, const DomainState<D>& state, ProcessGroup& group);

}  // namespace bipot
