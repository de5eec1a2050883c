#pragma once

#include <functional>
#include <string>

#include "core/motion/time_stepping.h"
#include "solvers/solver.h"

namespace bipot {

/// Runs a scene with its own solver choice (or `solver` if not empty) and hands every step to
/// `on_step`. Returns the final state. A step that does not converge fails the test that called.
State run_scene(const Scene& scene,
                const std::function<void(const State&, const StepReport&)>& on_step = {},
                const std::string& solver = "");

}  // namespace bipot
