#pragma once

#include <vector>

#include "core/motion/state.h"

namespace bipot {

/// Largest residuals of Newton's and Euler's equations of the disks and clusters. They are summed
/// contact by contact from the impulses of a state's last step, independently of any solver. Forces
/// are s/h.
template <int D>
struct ForceBalance {
  double force = 0;               ///< largest |Σ f + m g| of a disk over its weight
  double moment = 0;              ///< largest |Σ moments| of a disk over weight times radius
  Vec<D> walls = Vec<D>::Zero();  ///< by all walls on the disks            [N]
  std::vector<Vec<D>> wall;       ///< by each wall                         [N]
  double weight = 0;              ///< of all disks                         [N]
};

/// Force of the bodies on each wall in the last step; those on bodies glued to a wall count. [N]
template <int D>
std::vector<Vec<D>> wall_reactions(const State<D>& state, double step);

template <int D>
ForceBalance<D> force_balance(const Scene<D>& scene, const State<D>& state);

}  // namespace bipot
