#pragma once

#include <map>
#include <vector>

#include "bench/tradeoff/advice.h"
#include "bench/tradeoff/run_setting.h"

namespace bipot {

/// Means over a stretch of a run, and its cost. Weights are hat-shaped, so that a shock that moves
/// to the next step counts by its time.
struct StretchSample {
  RunRecord run;
  /// Mean contact force on each body there all the time, by its number; driven walls: -1 - wall. [N]
  std::map<int, Vec3> force;
  std::vector<Vec3> load;   ///< mean contact force on each wall                     [N]
  double dissipated = 0;    ///< [J]
  double penetration = 0;   ///< largest overlap that came up, over the smaller radius
  double coordination = 0;  ///< loaded contacts of a body
  double stress_ratio = 0;  ///< τ/P of the mean stress (core/observables/observables.h)
};

/// Time over which forces are averaged: as requested [s], 0: a fiftieth of the run. In steps of the
/// scene's, a multiple of 4.
template <int D>
int stretch_steps(const Scene<D>& scene, double asked);

/// Runs the scene for `steps` of its steps from a state. Ends at a step that is not solved to
/// limits.accepted.
template <int D>
StretchSample run_stretch(const Scene<D>& scene, State<D> state, int steps,
                          const RunSetting& setting, const RunLimits& limits);

/// Dissipation below this counts as zero: a thousandth of the kinetic energy, or of a fall by a
/// radius.
template <int D>
double energy_floor(const Scene<D>& scene, const State<D>& state);

/// Errors of samples (one for each stretch) against a `reference`, see Accuracy; no scaling. Errors
/// of means are those of the mean over the stretches from `first` on. The penetration is the
/// samples' own.
MeasuredError stretch_errors(const std::vector<StretchSample>& samples,
                             const std::vector<StretchSample>& reference, double floor,
                             std::size_t first);

/// Errors that a solver adds: the penetration is what exceeds that of the reference.
MeasuredError added_errors(const std::vector<StretchSample>& samples,
                           const std::vector<StretchSample>& reference, double floor,
                           std::size_t first);

}  // namespace bipot
