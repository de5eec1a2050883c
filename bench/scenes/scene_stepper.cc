#include "bench/scenes/scene_stepper.h"

#include <utility>

#include "solvers/registry.h"
#include "solvers/step_solver.h"

namespace bipot {

SceneStepper::SceneStepper(const Scene& scene, StepSolver solver, bool explicit_delassus,
                           std::function<bool()> cancelled, int threads) {
  if (!solver && scene.model == Model::kSpringDashpot) {
    springs_.emplace(scene, std::move(cancelled));
    return;
  }
  if (!solver) {
    const SolverEntry& entry = require_solver(scene.solver.name);
    SolverOptions choice = to_options(scene.solver);
    choice.cancelled = std::move(cancelled);
    choice.execution.threads = threads;
    solver = make_step_solver(entry, std::move(choice));
    explicit_delassus = entry.needs_delassus;
  }
  rigid_.emplace(
      scene,
      [this, solver = std::move(solver)](const ContactProblem& problem, const Vector& start) {
        start_ = start;
        return solver(problem, start);
      },
      explicit_delassus, threads);
}

StepReport SceneStepper::advance(State& state) {
  return springs_ ? springs_->advance(state) : rigid_->advance(state);
}

std::optional<SpringDashpotSetup> SceneStepper::springs() const {
  if (!springs_) return std::nullopt;
  return springs_->setup();
}

}  // namespace bipot
