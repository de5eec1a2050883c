#include "solvers/simulation/scene_stepper.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {

template <int D>
SceneStepper<D>::SceneStepper(const Scene<D>& scene, StepSolver solver, bool explicit_delassus,
                              std::function<bool()> cancelled, int threads, OnFailure on_failure)
    : scene_(scene), threads_(threads), on_failure_(on_failure) {
  if (!solver && scene.model == Model::kSpringDashpot) {
    if constexpr (D == 2) {
      springs_.emplace(scene, std::move(cancelled));
      return;
    } else {
      throw std::invalid_argument("the model dem simulates disks, not spheres");
    }
  }
  if (!solver) {
    const SolverEntry& entry = require_solver(scene.solver.name);
    SolverOptions choice = to_options(scene.solver);
    choice.cancelled = std::move(cancelled);
    choice.execution.threads = threads;
    solver = make_step_solver(entry, std::move(choice));
    explicit_delassus = entry.needs_delassus;
  }
  solver_ = std::move(solver);
  explicit_delassus_ = explicit_delassus;
  rigid_.emplace(
      scene,
      [this](const ContactProblem& problem, const Vector& start) {
        start_ = start;
        return solver_(problem, start);
      },
      explicit_delassus, threads);
}

template <int D>
StepReport<D> SceneStepper<D>::advance(State<D>& state) {
  parts_ = 1;
  if constexpr (D == 2) {
    if (springs_) return springs_->advance(state);
  }
  if (const int halvings = travel_halvings(scene_, state); halvings > 0) {
    SplitStep<D> split = advance_in_equal_parts(scene_, solver_, explicit_delassus_, state,
                                                halvings, on_failure_, threads_);
    parts_ = split.parts;
    return std::move(split.report);
  }
  if (on_failure_ == OnFailure::kContinue) return rigid_->advance(state);
  State<D> next = state;
  StepReport<D> whole;
  std::string why;
  try {
    whole = rigid_->advance(next);
    if (whole.converged) {
      state = std::move(next);
      return whole;
    }
    why = whole.message;
  } catch (const StepFailure& failure) {
    const bool numerical = failure.kind == StepFailure::Kind::kNumerical;
    if (!numerical || on_failure_ == OnFailure::kStop) throw;
    why = failure.what();
  }
  if (on_failure_ == OnFailure::kStop) {
    throw StepFailure(StepFailure::Kind::kNotConverged, state, why);
  }
  SplitStep<D> split = advance_in_parts(scene_, solver_, explicit_delassus_, state, threads_);
  parts_ = split.parts;
  split.report.add_cost(whole);
  return std::move(split.report);
}

template <int D>
std::optional<SpringDashpotSetup> SceneStepper<D>::springs() const {
  if (!springs_) return std::nullopt;
  return springs_->setup();
}

template class SceneStepper<2>;
template class SceneStepper<3>;

}  // namespace bipot
