#pragma once

#include <vector>

#include "core/motion/state.h"

namespace bipot {

/// Newton's and Euler's equations of every disk, summed up contact by contact from the impulses of
/// a state's last step, without any solver's help. Forces are s/h.
struct ForceBalance {
  double force = 0;           ///< largest |Σ f + m g| of a disk over its weight
  double moment = 0;          ///< largest |Σ moments| of a disk over weight times radius
  Vec2 walls = Vec2::Zero();  ///< by all walls on the disks                    [N]
  std::vector<Vec2> wall;     ///< by each wall                                 [N]
  double weight = 0;          ///< of all disks                                 [N]
};
ForceBalance force_balance(const Scene& scene, const State& state);

}  // namespace bipot
