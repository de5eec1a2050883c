#include "solvers/auto/auto_solver.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "solvers/auto/auto_plan.h"
#include "solvers/auto/recovered_disks.h"
#include "solvers/auto/stage_race.h"

namespace bipot {
namespace {

ProblemTraits traits_of(SolveRun& run) {
  if (run.space().whole() != nullptr) {
    return traits_of(run.problem(), run.delassus(), run.options());
  }
  // A process without contacts does not know whether those of the others roll.
  double rolling[1] = {run.problem().rolls() ? 1.0 : 0.0};
  run.space().sum(rolling);
  const int dim = run.problem().dim;
  const bool rolls = rolling[0] > 0;
  return {.contacts = run.space().whole_contacts(),
          .dim = rolls ? (dim == 6 ? 3 : 2) : dim,
          .tol = run.options().tol,
          .marks = kInParallel,
          .rolls = rolls};
}

/// `attempted`: the impulse that an attempt left, whose stages are not run again; or empty.
void race_plan(const AutoPlan& plan, SolveRun& run, const Vector& attempted, bool only_attempt) {
  const std::vector<AutoStage> stages = serving_stages(plan, traits_of(run));
  run.take(race_stages(run, stages, attempted, [&](const AutoStage& stage) {
    if (only_attempt) return stage.before_cutting;
    return !(attempted.size() != 0 && stage.on_whole_only);
  }));
}

void solve_by(const AutoPlan& plan, SolveRun& run) {
  const IslandSolver solver = plan_solver(plan);
  const bool islands = run.space().whole() != nullptr && run.options().islands.value_or(true);
  if (!islands) return solver.run(run, Vector());
  solve_islands(run, solver);
}

/// By the recovered bodies, then, where W rounds otherwise than they do, on W from there.
void solve_recovered(const AutoPlan& plan, const ContactProblem& bodies, SolveRun& run) {
  const SolverOptions& options = run.options();
  const SolverEntry entry = run.entry().with([&plan](SolveRun& part) { solve_by(plan, part); });
  run.space().release_scratch();
  WholeSpace space(bodies, options.execution.threads);
  SolveResult result = run_solver(entry, space, options, run.whole().share());
  result.message = "disks recovered from W: " + result.message;
  const bool missed = options.stop == StopTest::kGuarded && is_success(result.status) &&
                      !(run.space().error(result.s).guarded() <= options.tol);
  if (!missed) return run.take(std::move(result));
  SolverOptions rest = options;
  rest.s0 = result.s;
  rest.time_limit = run.remaining_seconds();
  rest.max_iterations -= std::min(result.iterations, options.max_iterations);
  SolveResult more = run.nested(entry, rest, run.whole().share());
  more.message = result.message + "; then by W: " + more.message;
  more.iterations += result.iterations;
  run.take(std::move(more));
}

}  // namespace

IslandSolver plan_solver(const AutoPlan& plan) {
  return {.run = [&plan](SolveRun& run, const Vector& best) { race_plan(plan, run, best, false); },
          .attempt = [&plan](SolveRun& run) { race_plan(plan, run, Vector(), true); }};
}

void solve_auto(SolveRun& run) {
  std::shared_ptr<const AutoPlan> own = run.options().plan;
  try {
    if (!own) own = named_plan(run.options().parameters);
  } catch (const std::exception& e) {
    return run.end(SolveStatus::kInvalidInput, e.what());
  }
  const AutoPlan& plan = own ? *own : shipped_plan();
  std::optional<ContactProblem> bodies;
  if (run.space().whole() != nullptr) bodies = recovered_disks(run.problem());
  if (bodies) return solve_recovered(plan, *bodies, run);
  solve_by(plan, run);
}

}  // namespace bipot
