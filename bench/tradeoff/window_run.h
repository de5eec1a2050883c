#pragma once

#include <functional>
#include <vector>

#include "bench/tradeoff/advice.h"
#include "core/motion/time_stepping.h"
#include "solvers/registry.h"
#include "solvers/solver.h"

namespace bipot {

/// Time over which forces are averaged: as requested [s], 0: a fiftieth of the run.
struct WindowLength {
  double seconds = 0;
  int steps = 0;  ///< of the scene's step, a multiple of 4
};
WindowLength window_length(const Scene<2>& scene, double asked);

/// Results of a stretch of a run.
struct WindowRun {
  bool usable = false;
  std::vector<Vec2>
      force;  ///< mean contact force on each body (measured_bodies.h), then driven walls [N]
  double dissipated = 0;   ///< [J]
  double penetration = 0;  ///< largest overlap added by one step                          [m]
};

/// Scales the impulses of lasting contacts, the warm start, with the step.
void scale_impulses(State<2>& state, double factor);

/// Runs the scene from a state for `steps` of its steps, which are `factor` times as long as those
/// of the state.
WindowRun run_window(const Scene<2>& scene, State<2> state, double factor, int steps,
                     const StepSolver& solver, double accepted);

/// Dissipation below this counts as zero: a thousandth of the kinetic energy, or of a fall by a
/// radius.
double energy_floor(const Scene<2>& scene, const State<2>& state);

/// Errors of `runs` (one for each window) against `reference`, see StepStudy; no scaling. The
/// penetration is the run's own.
Accuracy window_errors(const std::vector<WindowRun>& runs, const std::vector<WindowRun>& reference,
                       double radius, double floor);

/// A solver whose every step may take as long as `seconds_left` says at that time.
StepSolver limited_solver(const SolverEntry& entry, SolverOptions options,
                          std::function<double()> seconds_left);

}  // namespace bipot
