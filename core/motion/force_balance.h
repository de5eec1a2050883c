#pragma once

#include <vector>

#include "core/motion/state.h"

namespace bipot {

/// Newton's and Euler's equations of every disk, or cluster of disks, summed up contact by contact from the impulses of
/// a state's last step, without any solver's help. Forces are s/h.
template <int D>
struct ForceBalance {
  double force = 0;               ///< largest |Σ f + m g| of a disk over its weight
  double moment = 0;              ///< largest |Σ moments| of a disk over weight times radius
  Vec<D> walls = Vec<D>::Zero();  ///< by all walls on the disks            [N]
  std::vector<Vec<D>> wall;       ///< by each wall                         [N]
  double weight = 0;              ///< of all disks                         [N]
};

template <int D>
ForceBalance<D> force_balance(const Scene<D>& scene, const State<D>& state);

}  // namespace bipot
