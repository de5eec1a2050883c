#include "bench/command/run_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <variant>

#include "bench/command/exit_code.h"
#include "bench/command/failure_text.h"
#include "bench/command/interrupt.h"
#include "bench/command/progress_bar.h"
#include "bench/command/run_summary.h"
#include "bench/report/json_output.h"
#include "bench/scenes/run_folder.h"
#include "bench/scenes/scene_catalogue.h"
#include "core/file_error.h"
#include "core/files/run_layout.h"
#include "core/files/run_reader.h"
#include "core/files/scene_file.h"
#include "core/stopwatch.h"
#include "core/version.h"
#include "solvers/registry.h"
#include "solvers/solve.h"
#include "solvers/step_solver.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

/// A flag without effect would mislead.
void refuse_flags_of_the_other_model(const RunFlags& flags, Model model) {
  const SolverFlags& solver = flags.solver;
  if (model == Model::kSpringDashpot) {
    const char* flag = solver.name                                 ? "--solver"
                       : solver.stop                               ? "--stop"
                       : solver.tol                                ? "--tol"
                       : solver.max_iterations                     ? "--max-iterations"
                       : solver.warm_start                         ? "--warm-start"
                       : !solver.parameters.empty()                ? "a solver parameter"
                       : !flags.dump_problems.empty()              ? "--dump-problems"
                       : flags.on_failure != RunFlags{}.on_failure ? "--on-failure"
                                                                   : nullptr;
    if (flag != nullptr) {
      throw std::invalid_argument(fmt::format(
          "{} has no meaning under --model dem, which solves no contact problem", flag));
    }
    if (flags.stiffness && flags.overlap) {
      throw std::invalid_argument("give --stiffness or --overlap: one decides the other");
    }
    return;
  }
  const char* flag = flags.stiffness          ? "--stiffness"
                     : flags.overlap          ? "--overlap"
                     : flags.tangential_ratio ? "--tangential-ratio"
                     : flags.substep          ? "--substep"
                                              : nullptr;
  if (flag != nullptr) {
    throw std::invalid_argument(
        fmt::format("{} has no meaning under --model nscd, whose contacts are rigid", flag));
  }
}

/// Makes the command line's changes, and checks the outcome before anything is written.
template <int D>
void apply_flags(const RunFlags& flags, SceneIn<D>& scene) {
  if (flags.steps) scene.num_steps = *flags.steps;  // with --restart: from there
  if (flags.step_size) scene.step = *flags.step_size;
  scene.solver = merged(scene.solver, flags.solver);
  if (flags.model) {
    scene.model = *flags.model == "dem" ? Model::kSpringDashpot : Model::kNonsmooth;
  }
  if (D == 3 && scene.model == Model::kSpringDashpot) {
    throw std::invalid_argument("the model dem simulates disks, not spheres");
  }
  refuse_flags_of_the_other_model(flags, scene.model);
  if (flags.stiffness) scene.dem.stiffness = *flags.stiffness;
  if (flags.overlap) {
    scene.dem.overlap = *flags.overlap;
    scene.dem.stiffness = 0;
  }
  if (flags.tangential_ratio) scene.dem.tangential_ratio = *flags.tangential_ratio;
  if (flags.substep) scene.dem.substep = *flags.substep;
  if (auto defect = validate(scene); !defect.empty()) throw std::invalid_argument(defect);
}

/// What the flags ask to be written; no folder without --out.
RunFolderOptions folder_options(const RunFlags& flags, const std::string& scene_text) {
  using Problems = RunFolderOptions::Problems;
  RunFolderOptions folder;
  folder.folder = flags.common.out;
  folder.scene_text = scene_text;
  folder.program = "bipot " + program_version();
  folder.problems = flags.dump_problems == "all"      ? Problems::kAll
                    : flags.dump_problems == "failed" ? Problems::kFailed
                                                      : Problems::kNone;
  folder.resume = !flags.common.out.empty() && !flags.restart.empty() &&
                  fs::exists(folder.folder) &&
                  fs::equivalent(folder.folder, run_folder(flags.restart));
  return folder;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileError(folder, "", "cannot create: " + error.message());
}

/// A run that was at its end already. Its files stay as they are.
template <int D>
int nothing_to_do(const RunFlags& flags, const SceneIn<D>& scene, const StateIn<D>& state,
                  bool quiet) {
  const std::string message = fmt::format(
      "{} is at step {}, the scene ends at step {}: nothing to do (--steps N takes N "
      "more)",
      flags.restart, state.step, scene.num_steps);
  if (!flags.common.json.empty()) {
    require_writable(flags.common.json);
    write_json({{"command", "run"},
                {"version", program_version()},
                {"scene", scene.source},
                {"status", "nothing to do"},
                {"exit_code", static_cast<int>(kExitConverged)},
                {"message", message},
                {"steps", 0},
                {"last_step", state.step},
                {"time", state.time}},
               flags.common.json);
  }
  if (!quiet) fmt::print("{}\n", message);
  return kExitConverged;
}

struct RunOutcome {
  std::string status;
  ExitCode exit_code;
};

template <int D>
RunOutcome outcome_of(const SceneRunIn<D>& run) {
  using End = typename SceneRunIn<D>::End;
  if (run.end == End::kFailed) {
    return run.failure->kind == StepFailure::Kind::kInvalidInput
               ? RunOutcome{"invalid input", kExitBadInput}
           : run.failure->kind == StepFailure::Kind::kNotConverged
               ? RunOutcome{"not converged", kExitNotConverged}
               : RunOutcome{"failed", kExitNumericalFailure};
  }
  if (InterruptGuard::requested()) return {"interrupted", kExitInterrupted};
  if (run.end == End::kCancelled) return {"time limit", kExitNotConverged};
  if (run.totals.converged < run.totals.steps) return {"not converged", kExitNotConverged};
  return {"completed", kExitConverged};
}

/// `text`: of the scene's file.
template <int D>
int run_in(const RunFlags& flags, SceneIn<D> scene, const std::string& text) {
  apply_flags(flags, scene);
  const bool dem = scene.model == Model::kSpringDashpot;
  const SolverEntry& entry = require_solver(dem ? SolverChoice{}.name : scene.solver.name);
  SolverOptions options = to_options(dem ? SolverChoice{} : scene.solver);
  options.execution.threads = flags.common.threads;
  // A first look at the options on a problem without contacts: wrong ones are refused here.
  if (const SolveResult probe = solve(entry, ContactProblem{}, options);
      probe.status == SolveStatus::kInvalidInput) {
    throw std::invalid_argument(probe.message);
  }
  if (flags.common.out.empty() && !flags.dump_problems.empty()) {
    throw std::invalid_argument("--dump-problems needs --out DIR");
  }
  if constexpr (D == 2) {
    if (dem) spring_dashpot_setup(scene);  // refuses before anything is written
  }

  const Stopwatch watch;
  StateIn<D> state = flags.restart.empty() ? initial_state(scene) : read_state<D>(flags.restart);
  if (const std::string mismatch = restart_mismatch(scene, state); !mismatch.empty()) {
    throw std::invalid_argument(flags.restart + " does not fit the scene: " + mismatch);
  }
  if (flags.steps) scene.num_steps = state.step + *flags.steps;
  const bool json_on_stdout = flags.common.json == "-";
  const bool quiet = flags.common.quiet || json_on_stdout;
  if (!flags.restart.empty() && state.step >= scene.num_steps) {
    return nothing_to_do(flags, scene, state, quiet);
  }
  RunFolderOptions folder = folder_options(flags, text);
  if (!folder.folder.empty()) make_folder(folder.folder);
  require_writable(flags.common.json);  // may lie in the folder that was just made

  const InterruptGuard interrupt;
  const double limit = flags.common.time_limit;
  SceneRunOptionsIn<D> run_options;
  run_options.steps = scene.num_steps - state.step;
  if (!dem) {
    run_options.solver = [&](const ContactProblem& problem, const Vector& s0) {
      options.time_limit = std::max(limit - watch.seconds(), 1e-3);
      options.cancelled = &InterruptGuard::requested;
      return make_step_solver(entry, options)(problem, s0);
    };
  }
  run_options.explicit_delassus = entry.needs_delassus;
  run_options.threads = flags.common.threads;
  run_options.on_failure = flags.on_failure == "stop"           ? OnFailure::kStop
                           : flags.on_failure == "smaller-step" ? OnFailure::kSmallerStep
                                                                : OnFailure::kContinue;
  const bool smaller_steps = run_options.on_failure == OnFailure::kSmallerStep;
  run_options.cancelled = [&] { return InterruptGuard::requested() || watch.seconds() > limit; };
  SceneRunIn<D> run;
  std::string advice;  // on the first step that was not solved
  EnergyGrowth growth(state);
  {
    ProgressBar progress(*run_options.steps, quiet);
    run_options.on_step = [&, first = state.step](const SceneStepIn<D>& step) {
      growth.add(scene, step);
      if (!step.report.converged && advice.empty() && !quiet) {
        advice = failure_text<D>(scene, step.state, step.state.contacts, step.problem,
                                 step.report.error, step.report.step, smaller_steps);
      }
      progress.update(
          step.report.step - first,
          fmt::format("{} contacts, {} iterations", step.report.contacts, step.report.iterations));
      return true;
    };
    run = folder.folder.empty() ? run_scene(scene, state, run_options)
                                : run_scene_into(scene, state, run_options, folder);
  }
  const auto [status, exit_code] = outcome_of(run);
  if (run.failure) {
    fmt::print(stderr, "bipot: {}\n", run.failure->what());
    if (!quiet && (exit_code == kExitNumericalFailure || exit_code == kExitNotConverged)) {
      advice = failure_text(scene, state, run, smaller_steps);
    }
  }
  if (!advice.empty() && !quiet) fmt::print(stderr, "{}", advice);
  if (const std::string warning = growth.warning(scene); !warning.empty() && !flags.common.quiet) {
    fmt::print(stderr, "{}", warning);
  }
  const RunSummary<D> summary{scene,           state,           run, status, exit_code,
                              watch.seconds(), flags.common.out};
  const auto json = to_json(summary);
  if (!flags.common.out.empty()) write_json(json, (folder.folder / "summary.json").string());
  if (!flags.common.json.empty()) write_json(json, flags.common.json);
  if (!quiet) fmt::print("{}", to_text(summary));
  return exit_code;
}

}  // namespace

CommandDeclaration add_run_command(CommandLine& line, RunFlags& flags) {
  CommandDeclaration command =
      line.add_command("run", "Run a scene: time steps, files, pictures, summary");
  command.option("scene", flags.scene, "Scene file (TOML) or the name of a shipped scene")
      .required();
  command
      .option("--steps", flags.steps,
              "Number of steps instead of the scene's; with --restart: more steps")
      .value_name("N")
      .not_negative();
  command.option("--step-size", flags.step_size, "Time step, instead of the scene's")
      .value_name("SECONDS")
      .positive();
  command
      .option("--restart", flags.restart,
              "Go on from the last frame of that run (folder or run.h5)")
      .value_name("RUN");
  command
      .option("--model", flags.model,
              "nscd: rigid, one contact problem a step; dem: springs and dashpots")
      .one_of({"nscd", "dem"});
  const auto dem = [&](const char* name, std::optional<double>& value, const char* unit,
                       const char* help) {
    command.option(name, value, help).value_name(unit).group("Model dem");
  };
  dem("--stiffness", flags.stiffness, "N/m", "Normal stiffness (default: by --overlap)");
  dem("--overlap", flags.overlap, "FRACTION",
      "Overlap aimed at, of the smallest radius: decides the stiffness");
  dem("--tangential-ratio", flags.tangential_ratio, "FRACTION", "Tangential over normal stiffness");
  dem("--substep", flags.substep, "SECONDS", "Largest substep (default: from the stability limit)");
  add_common_flags(command, flags.common);
  command
      .option("--dump-problems", flags.dump_problems,
              "Write the steps' contact problems as FCLIB files into DIR/problems")
      .one_of({"all", "failed"})
      .group("Results");
  command
      .option("--on-failure", flags.on_failure,
              "Unsolved step: continue (take it), stop, or smaller-step (in parts)")
      .one_of({"continue", "stop", "smaller-step"})
      .value_name("WORD");
  add_solver_flags(command, flags.solver);
  add_warm_start_flags(command, flags.solver);
  command.footer(
      "Examples:\n"
      "  bipot run compaction --out out/compaction\n"
      "  bipot run compaction --out out/b --restart out/a --steps 100");
  return command;
}

int run_command(const RunFlags& flags) {
  const fs::path path = find_scene(flags.scene);
  std::ifstream file(path);
  std::ostringstream content;
  content << file.rdbuf();
  const std::string text = content.str();
  return std::visit([&](auto&& scene) { return run_in(flags, std::move(scene), text); },
                    parse_any_scene(text, path.string()));
}

}  // namespace bipot
