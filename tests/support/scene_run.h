#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <type_traits>

#include "core/motion/time_stepping.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"
#include "solvers/solver.h"

namespace bipot {

/// Runs a scene with its own solver choice (or `solver` if not empty) and hands every step to
/// `on_step`. Returns the final state. A step that does not converge fails the test that called.
template <int D>
State<D> solved_run(const Scene<D>& scene,
                    const std::type_identity_t<
                        std::function<void(const State<D>&, const StepReport<D>&)>>& on_step = {},
                    const std::string& solver = "");

/// A stepper with a solver of that name and the scene's tolerances.
template <int D>
TimeStepper<D> stepper_of(const Scene<D>& scene, const char* solver = "auto") {
  return {scene, make_step_solver(require_solver(solver), to_options(scene.solver)), false};
}

/// Takes steps; momentum and energy must balance in each. The report of the last one.
template <int D>
StepReport<D> balanced_steps(const Scene<D>& scene, State<D>& state, int steps,
                             double bound = 1e-10) {
  EXPECT_EQ(validate(scene), "");
  TimeStepper<D> stepper = stepper_of(scene);
  StepReport<D> r;
  for (int k = 0; k < steps; ++k) {
    r = stepper.advance(state);
    EXPECT_TRUE(r.converged) << r.message;
    EXPECT_LT(std::abs(r.energy.imbalance), bound);
    EXPECT_LT(r.momentum_imbalance.norm(), bound);
  }
  return r;
}
/// The state after such steps.
template <int D>
State<D> after_steps(const Scene<D>& scene, int steps, double bound = 1e-10) {
  State<D> state = initial_state(scene);
  balanced_steps(scene, state, steps, bound);
  return state;
}

}  // namespace bipot
