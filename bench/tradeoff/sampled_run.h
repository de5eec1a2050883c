#pragma once

#include <cstddef>
#include <vector>

#include "bench/tradeoff/advice.h"
#include "bench/tradeoff/time_budget.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// A state from which the next step has contacts, and an earlier one from which a window reaches
/// over it.
struct Checkpoint {
  State<2> state, lead;
};

/// The run that samples are taken from.
struct SampledRun {
  SceneSample seen;
  std::vector<Checkpoint> checkpoints;  ///< evenly along the steps with contacts
};

/// Runs the scene with `auto` to the tolerance until it ends, fails or the part of the time is
/// spent.
SampledRun sampled_run(const Scene<2>& scene, double tol, double part, const AdviseOptions& options,
                       const TimeBudget& time);

/// Which checkpoints to choose on, and which to verify on: evenly spaced, each third one fresh.
struct Selection {
  std::vector<std::size_t> sample, fresh;
};
Selection select_steps(std::size_t available, int samples, int fresh);

}  // namespace bipot
