#pragma once

#include <vector>

#include "core/motion/state.h"
#include "core/scene/scene.h"
#include "solvers/simulation/domain_state.h"

namespace bipot {

/// The bodies that one process looks at in a step: its own, and copies of others' (ghosts).
template <int D>
struct LocalBodies {
  std::vector<int> numbers;  ///< in the whole, ascending
  std::vector<int> owner;    ///< rank, of each
  std::vector<int> own;      ///< places of the own ones, ascending
  State<D> state;            ///< own bodies and ghosts before the step, with the walls
};

/// Every process learns the box of each other's bodies at mid-step and sends it the bodies within
/// reach: whoever touches somebody who touches one of the others' bodies, so that all contacts of
/// the bodies that an owned contact pushes can be found where they are needed. Within reach is who
/// comes nearer to the box than twice the interaction distance and the largest diameter. Ghosts
/// have the bits of their originals. One message to each process that is near. Collective.
template <int D>
LocalBodies<D> with_ghosts(const Scene<D>& scene, const DomainState<D>& state, ProcessGroup& group);

}  // namespace bipot
