#include "solvers/simulation/run_folder.h"

#include <fmt/format.h>

#include <system_error>
#include <vector>

#include "core/base/number_text.h"
#include "core/pictures/flat_view.h"
#include "core/pictures/force_picture.h"
#include "core/pictures/stress_picture.h"
#include "core/problem_files/fclib_file.h"
#include "core/problem_files/problem_geometry.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

template <int D>
std::string caption(const Scene<D>& scene, const SceneTotals<D>& totals, const State<D>& state) {
  const std::string& title = scene.title.empty() ? scene.source : scene.title;
  if (scene.model == Model::kSpringDashpot) {
    return fmt::format("{}: step {}, t = {:.4g} s, springs and dashpots, {} substeps a step", title,
                       state.step, state.time, totals.last.iterations);
  }
  return fmt::format("{}: step {}, t = {:.4g} s, solver {}, max(ε, η) = {:.1e} (tol {})", title,
                     state.step, state.time, scene.solver.name, totals.last.error.guarded(),
                     tolerance_label(scene.solver.tol));
}

}  // namespace

bool needs_state(const OutputChoice& output, int step) {
  const auto every = [&](int steps) { return steps > 0 && step % steps == 0; };
  return every(output.every) || every(output.ledger_every) || !output.track.empty();
}

template <int D>
RunFolder<D>::RunFolder(const Scene<D>& scene, const State<D>& state,
                        const RunFolderOptions& options)
    : scene_(scene),
      options_(options),
      writer_(options.folder, scene, options.scene_text, options.resume ? state.step : -1) {
  writer_.frame(state);
  // Page and film of an earlier run would show what is no longer there.
  std::error_code none;
  fs::remove(options.folder / "index.html", none);
  if (scene.output.page) {
    film_.emplace(options.folder, scene, options.resume ? state.step : -1);
    film_->step(state);
  } else {
    fs::remove(options.folder / kFilmFile, none);
  }
}

template <int D>
void RunFolder<D>::step(const SceneStep<D>& step) {
  using Problems = RunFolderOptions::Problems;
  if (options_.problems == Problems::kAll ||
      (options_.problems == Problems::kFailed && !step.report.converged)) {
    write_problem(step.problem, step.start, step.report);
    if constexpr (D == 2) {
      // Ropes, and some of Poisson's second phase, are contacts without a place; the state has the
      // contacts of the whole step.
      const std::size_t contacts = to_size(step.problem.num_contacts());
      if (contacts > 0 && contacts == step.state.contacts.size() && !step.cut) {
        write_geometry(problem_path(step.report.step), scene_, step.state);
      }
    }
  }
  writer_.step(step.state, step.report);
  framed_ = scene_.output.every > 0 && step.state.step % scene_.output.every == 0;
  if (framed_) writer_.frame_beside(step.state);
  // Of a distributed state this process has the bodies at steps that are written anyway.
  const bool whole = !step.state.bodies.empty() || scene_.has_gates() || scene_.bodies.empty();
  if (film_ && whole) film_->step(step.state);
}

template <int D>
void RunFolder<D>::finish(const State<D>& state, const SceneRun<D>& run) {
  // A failed step always leaves its problem.
  using Kind = StepFailure::Kind;
  const bool unsolved = run.failure && (run.failure->kind == Kind::kNumerical ||
                                        run.failure->kind == Kind::kNotConverged ||
                                        run.failure->kind == Kind::kUnsolvable);
  if (unsolved || (run.failure && options_.problems != RunFolderOptions::Problems::kNone)) {
    StepReport<D> failed;
    failed.step = state.step + 1;
    failed.time = state.time + scene_.step;
    failed.message = run.failure->what();
    write_problem(run.failed_problem, run.failed_start, failed);
  }
  if (!framed_) writer_.frame(state);
  writer_.finish(state);
  if (film_) film_->finish(state);
  draw(state, run.totals);
}

template <int D>
fs::path RunFolder<D>::problem_path(int step) const {
  return options_.folder / "problems" / fmt::format("step_{:06d}.hdf5", step);
}

template <int D>
void RunFolder<D>::write_problem(const ContactProblem& problem, const Vector& start,
                                 const StepReport<D>& report) {
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

/// Drawings of more bodies than this are of pixels only: cairo holds every line of a vector drawing
/// in memory, and viewers hardly open it.
constexpr std::size_t kMostVectorBodies = 20000;

std::vector<const char*> formats_of(const State<2>& state) {
  if (state.bodies.size() > kMostVectorBodies) return {".png"};
  return {".svg", ".png"};
}

/// Draws NAME in the formats of formats_of().
void draw_forces(const fs::path& folder, const std::string& name, const Scene<2>& scene,
                 const State<2>& state, const std::string& text_below) {
  for (const char* format : formats_of(state)) {
    draw_force_picture(folder / (name + format), scene, state, text_below);
  }
}

void draw_stresses(const fs::path& folder, const Scene<2>& scene, const State<2>& state,
                   const std::vector<double>& pressures, const std::string& text_below) {
  for (const char* format : formats_of(state)) {
    draw_stress_picture(folder / (std::string("stress") + format), scene, state, pressures,
                        text_below);
  }
}

template <>
void RunFolder<2>::draw(const State<2>& state, const SceneTotals<2>& totals) const {
  const std::string text_below = caption(scene_, totals, state);
  if (scene_.output.picture) {
    draw_forces(options_.folder, "forces", scene_, state, text_below);
  }
  if (scene_.output.stress_picture) {
    draw_stresses(options_.folder, scene_, state, disk_pressures(state, scene_.step), text_below);
  }
}

template <>
void RunFolder<3>::draw(const State<3>& state, const SceneTotals<3>& totals) const {
  const std::string text_below = caption(scene_, totals, state);
  if (scene_.output.picture) {
    const FlatView all = project(scene_, state), cut = slice(scene_, state);
    draw_forces(options_.folder, "forces", all.scene, all.state,
                text_below + "; seen from the side");
    draw_forces(options_.folder, "slice", cut.scene, cut.state,
                text_below + "; cut through the middle");
  }
  if (scene_.output.stress_picture) {
    const FlatView cut = slice(scene_, state);
    const std::vector<double> of_all = disk_pressures(state, scene_.step);
    std::vector<double> pressures;
    for (const int k : cut.bodies) pressures.push_back(of_all[to_size(k)]);
    draw_stresses(options_.folder, cut.scene, cut.state, pressures,
                  text_below + "; cut through the middle");
  }
}

template class RunFolder<2>;
template class RunFolder<3>;

}  // namespace bipot
