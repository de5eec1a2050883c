#pragma once

#include <functional>
#include <string>
#include <type_traits>

#include "core/motion/time_stepping.h"
#include "solvers/solver.h"

namespace bipot {

/// Runs a scene with its own solver choice (or `solver` if not empty) and hands every step to
/// `on_step`. Returns the final state. A step that does not converge fails the test that called.
template <int D>
State<D> solved_run(const Scene<D>& scene,
                    const std::type_identity_t<
                        std::function<void(const State<D>&, const StepReport<D>&)>>& on_step = {},
                    const std::string& solver = "");

}  // namespace bipot
