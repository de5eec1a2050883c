#pragma once

#include <cstdint>
#include <functional>

#include "core/base/interrupt.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// A pile of `count` disks of three sizes (family "random" of scene_family.h) that fell into its
/// box and came to rest: the hardest realistic scene for a cold start. Contacts are those of the
/// simulation (h = 0.01 s, e = 0). It runs at a loose tolerance until the kinetic energy is below
/// `rest` times the initial potential energy, or for 3000 steps.
struct SettledPile {
  struct Options {
    int count = 1000;
    double mu = 0.3;
    std::uint64_t seed = 1;
    double rest = 1e-9;
    double tol = 1e-3;
    std::function<bool()> cancelled = &InterruptGuard::requested;
  };
  Scene<2> scene;  ///< disks at their settled places, velocities kept
  State<2> state;
  int steps = 0;
  bool at_rest = false;
};
/// Throws StepFailure, and Interrupted once `cancelled` is true.
SettledPile settle_pile(const SettledPile::Options& options);

}  // namespace bipot
