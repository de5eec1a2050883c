#pragma once

#include <type_traits>

#include "core/motion/time_stepping.h"
#include "core/run_files/run_output.h"
#include "core/run_files/run_reader.h"
#include "core/scene/scene_parts.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/step_solver.h"
#include "tests/support/state_bits.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/test.h"

namespace bipot {

template <int D>
using OnStep = std::type_identity_t<std::function<void(const State<D>&, const StepReport<D>&)>>;

/// Runs a scene with its own solver choice (or `solver` if not empty) and hands every step to
/// `on_step`. Returns the final state. A step that does not converge fails the test that called.
template <int D>
State<D> solved_run(const Scene<D>& scene, const OnStep<D>& on_step = {},
                    const std::string& solver = "");
/// The same over that many steps, whatever the scene has.
template <int D>
State<D> solved_run(Scene<D> scene, int steps, const OnStep<D>& on_step = {}) {
  scene.num_steps = steps;
  return solved_run(scene, on_step);
}

/// Such a run whose books close: imbalances of energy [J] and momentum [N s] stay below, step by
/// step.
template <int D>
State<D> closed_run(const Scene<D>& scene, int steps, double energy, double momentum) {
  return solved_run(scene, steps, [=](const State<D>&, const StepReport<D>& r) {
    EXPECT_LT(std::abs(r.energy.imbalance), energy) << "step " << r.step;
    EXPECT_LT(r.momentum_imbalance.norm(), momentum) << "step " << r.step;
  });
}

/// A stepper of the scene with that solver, by the scene's options or by others.
template <int D>
TimeStepper<D> stepper_of(const Scene<D>& scene, const std::string& solver,
                          const SolverOptions& options) {
  const SolverEntry& entry = require_solver(solver);
  return TimeStepper<D>(scene, make_step_solver(entry, options));
}
template <int D>
TimeStepper<D> stepper_of(const Scene<D>& scene, const std::string& solver = "auto") {
  return stepper_of(scene, solver, to_options(scene.solver));
}

/// Takes steps with `auto`; in each, energy and momentum must balance to `bound`.
template <int D>
void balanced_steps(const Scene<D>& scene, State<D>& state, int steps, double bound = 1e-10) {
  EXPECT_EQ(validate(scene), "");
  TimeStepper<D> stepper = stepper_of(scene);
  for (int k = 0; k < steps; ++k) {
    const StepReport<D> r = stepper.advance(state);
    EXPECT_TRUE(r.converged) << r.message;
    EXPECT_LT(std::abs(r.energy.imbalance), bound);
    EXPECT_LT(r.momentum_imbalance.norm(), bound);
  }
}

/// The state after steps of that kind.
template <int D>
State<D> after_steps(const Scene<D>& scene, int steps, double bound = 1e-10) {
  State<D> state = initial_state(scene);
  balanced_steps(scene, state, steps, bound);
  return state;
}

/// A run that is cut after `at` steps and goes on from its folder must end with the same bits.
/// Returns its end. `folder`: further options.
template <int D>
State<D> expect_exact_restart(const Scene<D>& scene, int at, RunFolderOptions folder = {}) {
  const TemporaryFolder place;
  folder.folder = place / "run";
  State<D> whole = initial_state(scene), part = whole;
  run_scene(scene, whole);
  run_scene(scene, part, {.steps = at, .folder = folder});
  State<D> again = read_state<D>(folder.folder);
  EXPECT_EQ(restart_mismatch(scene, again), "");
  run_scene(scene, again, {.steps = scene.num_steps - at});
  EXPECT_EQ(bits_of_state(again), bits_of_state(whole));
  return whole;
}

}  // namespace bipot
