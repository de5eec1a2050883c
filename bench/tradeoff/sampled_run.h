#pragma once

#include <cstddef>
#include <vector>

#include "bench/tradeoff/advice.h"
#include "bench/tradeoff/time_budget.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// A state whose next step has contacts, and an earlier one from which a window reaches over it.
struct Checkpoint {
  State<2> state, lead;
};

/// The run from which samples are taken.
struct SampledRun {
  SceneSample seen;
  std::vector<Checkpoint> checkpoints;  ///< evenly along the steps with contacts
};

/// Runs the scene with `auto` to the tolerance until it ends, fails or the part of the time is
/// used.
SampledRun sampled_run(const Scene<2>& scene, double tol, double part, const AdviseOptions& options,
                       const TimeBudget& time);

/// Checkpoints for the choice and for its verification: evenly spaced, every third one fresh.
struct Selection {
  std::vector<std::size_t> sample, fresh;
};
Selection select_steps(std::size_t available, int samples, int fresh);

}  // namespace bipot
