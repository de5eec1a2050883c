#include "bench/experiments/warm_start_study.h"

#include "bench/measure/stopwatch.h"
#include "core/motion/time_stepping.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/step_solver.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

int count_carried(const ContactProblem& p, const Vector& s0) {
  int carried = 0;
  for (Eigen::Index row = 0; row < s0.size(); row += p.dim) carried += s0[row] > 0 ? 1 : 0;
  return carried;
}

struct Timed {
  SolveResult result;
  double seconds = 0;
};
Timed timed_solve(const SolverVariant& variant, const ContactProblem& p, SolverOptions options,
                  const Vector& s0) {
  options.s0 = s0;
  options.parameters = variant.parameters;
  const CpuStopwatch watch;
  Timed timed{solve(variant.solver, p, options)};
  timed.seconds = watch.seconds();
  return timed;
}

}  // namespace

std::vector<WarmStartRow> study_warm_start(Scene<2> scene, const WarmStartOptions& options) {
  scene.solver.warm_start = true;
  SolverOptions run{.tol = options.run_tol,
                    .max_iterations = options.run_iterations,
                    .parameters = options.runner.parameters};
  const StepSolver runner = make_step_solver(require_solver(options.runner.solver), run);
  SolverOptions compared{.tol = options.tol, .max_iterations = options.max_iterations};

  std::vector<WarmStartRow> rows;
  State<2> state = initial_state(scene);
  SceneRunOptions<2> taken;
  taken.solver = [&](const ContactProblem& p, const Vector& s0) {
    if ((state.step + 1) % options.every == 0 && p.num_contacts() > 0) {
      WarmStartRow row;
      row.step = state.step + 1;
      row.time = row.step * scene.step;
      row.kinetic = kinetic_energy(state);
      row.contacts = p.num_contacts();
      row.carried = count_carried(p, s0);
      for (const SolverVariant& variant : options.solvers) {
        const Timed cold = timed_solve(variant, p, compared, Vector());
        const Timed warm = timed_solve(variant, p, compared, s0);
        row.solver = variant.label;
        row.cold = cold.result.iterations;
        row.warm = warm.result.iterations;
        row.cold_met = is_success(cold.result.status);
        row.warm_met = is_success(warm.result.status);
        row.cold_seconds = cold.seconds;
        row.warm_seconds = warm.seconds;
        rows.push_back(row);
      }
    }
    return runner(p, s0);
  };
  taken.cancelled = options.interrupted;
  taken.on_step = [&](const SceneStep<2>& step) {
    if (options.on_step) options.on_step(step.report.step);
    return true;
  };
  const SceneRun<2> whole = run_scene(scene, state, taken);
  if (whole.failure) throw *whole.failure;
  if (whole.end == SceneRun<2>::End::kCancelled) return {};
  return rows;
}

}  // namespace bipot
