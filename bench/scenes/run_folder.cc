#include "bench/scenes/run_folder.h"

#include <fmt/format.h>

#include <vector>

#include "bench/report/chart.h"
#include "bench/scenes/observable_charts.h"
#include "core/files/fclib_file.h"
#include "core/files/problem_geometry.h"
#include "core/motion/stress_tensor.h"
#include "core/pictures/force_picture.h"
#include "core/pictures/stress_picture.h"
#include "core/stopwatch.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

std::string caption(const Scene& scene, const SceneTotals& totals, const State& state) {
  const std::string& title = scene.title.empty() ? scene.source : scene.title;
  if (scene.model == Model::kSpringDashpot) {
    return fmt::format("{}: step {}, t = {:.4g} s, springs and dashpots, {} substeps a step", title,
                       state.step, state.time, totals.last.iterations);
  }
  return fmt::format("{}: step {}, t = {:.4g} s, solver {}, max(ε, η) = {:.1e} (tol {:.0e})", title,
                     state.step, state.time, scene.solver.name, totals.last.error.guarded(),
                     scene.solver.tol);
}

}  // namespace

RunFolder::RunFolder(const Scene& scene, const State& state, const RunFolderOptions& options)
    : scene_(scene),
      options_(options),
      writer_(options.folder, scene, options.scene_text, options.resume ? state.step : -1) {
  if (scene.observables) require_plotting_tool();
  writer_.frame(state);
}

void RunFolder::step(const SceneStep& step) {
  using Problems = RunFolderOptions::Problems;
  if (options_.problems == Problems::kAll ||
      (options_.problems == Problems::kFailed && !step.report.converged)) {
    write_problem(step.problem, step.start, step.report);
    if (step.problem.num_contacts() > 0) {
      write_geometry(problem_path(step.report.step), scene_, step.state);
    }
  }
  writer_.step(step.state, step.report);
  framed_ = scene_.output.every > 0 && step.state.step % scene_.output.every == 0;
  if (framed_) writer_.frame(step.state);
}

void RunFolder::finish(const State& state, const SceneRun& run) {
  // A step that could not be taken always leaves its problem.
  using Kind = StepFailure::Kind;
  const bool unsolved = run.failure && (run.failure->kind == Kind::kNumerical ||
                                        run.failure->kind == Kind::kNotConverged);
  if (unsolved || (run.failure && options_.problems != RunFolderOptions::Problems::kNone)) {
    StepReport failed;
    failed.step = state.step + 1;
    failed.time = state.time + scene_.step;
    failed.message = run.failure->what();
    write_problem(run.failed_problem, run.failed_start, failed);
  }
  if (!framed_) writer_.frame(state);
  writer_.close();
  draw(state, run.totals);
  if (scene_.observables) draw_observables(options_.folder);
}

fs::path RunFolder::problem_path(int step) const {
  return options_.folder / "problems" / fmt::format("step_{:06d}.hdf5", step);
}

void RunFolder::write_problem(const ContactProblem& problem, const Vector& start,
                              const StepReport& report) {
  if (problem.num_contacts() == 0) return;  // FCLIB has no empty problem
  const fs::path path = problem_path(report.step);
  fs::create_directories(path.parent_path());
  write_fclib(path, problem,
              {.title = fmt::format("{}, step {}", scene_.title, report.step),
               .description = fmt::format(
                   "{}, scene {}, step {} at t = {} s, h = {} s; solver {}: {}", options_.program,
                   fs::path(scene_.source).filename().string(), report.step, report.time,
                   scene_.step, scene_.solver.name, report.message)},
              start.size() > 0 ? std::vector<Vector>{start} : std::vector<Vector>{});
}

void RunFolder::draw(const State& state, const SceneTotals& totals) const {
  const std::string text_below = caption(scene_, totals, state);
  if (scene_.output.picture) {
    draw_force_picture(options_.folder / "forces.svg", scene_, state, text_below);
    draw_force_picture(options_.folder / "forces.png", scene_, state, text_below);
  }
  if (scene_.output.stress_picture) {
    const std::vector<double> pressures = disk_pressures(state, scene_.step);
    draw_stress_picture(options_.folder / "stress.svg", scene_, state, pressures, text_below);
    draw_stress_picture(options_.folder / "stress.png", scene_, state, pressures, text_below);
  }
}

SceneRun run_scene_into(const Scene& scene, State& state, const SceneRunOptions& run,
                        const RunFolderOptions& folder) {
  double seconds = 0;
  const auto timed = [&seconds](const auto& write) {
    const Stopwatch watch;
    write();
    seconds += watch.seconds();
  };
  RunFolder files(scene, state, folder);
  SceneRunOptions written = run;
  written.on_step = [&](const SceneStep& step) {
    timed([&] { files.step(step); });
    return !run.on_step || run.on_step(step);
  };
  SceneRun result = run_scene(scene, state, written);
  timed([&] { files.finish(state, result); });
  result.output_seconds = seconds;
  return result;
}

}  // namespace bipot
