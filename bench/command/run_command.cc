#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/failure_text.h"
#include "bench/command/run_processes.h"
#include "bench/command/run_progress.h"
#include "bench/command/run_summary.h"
#include "bench/command/say.h"
#include "bench/measure/peak_memory.h"
#include "bench/page/run_page.h"
#include "bench/page/watch_server.h"
#include "bench/problems/observable_charts.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/report/chart.h"
#include "bench/report/csv_text.h"
#include "bench/report/json_output.h"
#include "bench/report/text_lines.h"
#include "core/base/file_error.h"
#include "core/base/interrupt.h"
#include "core/base/stopwatch.h"
#include "core/base/version.h"
#include "core/files/folder_lock.h"
#include "core/files/input_file.h"
#include "core/run_files/run_layout.h"
#include "core/run_files/run_reader.h"
#include "core/scene/opposite_walls.h"
#include "core/scene_files/scene_file.h"
#include "solvers/parallel/launch.h"
#include "solvers/simulation/domain.h"
#include "solvers/simulation/scene_start.h"
#include "solvers/simulation/scene_stepper.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

struct RunFlags {
  CommonFlags common;
  SolverFlags solver;
  std::string scene;
  std::optional<int> steps;
  std::optional<double> step_size, duration, accuracy;
  std::string restart;        ///< folder or run.h5 of an earlier run
  bool overwrite = false;     ///< deletes a run in the folder of the results
  std::string dump_problems;  ///< "", "all" or "failed"
  /// "continue", "stop", "smaller-step"; empty: continue, but not where there is no solution
  std::string on_failure;
  std::string on_tunnel = "stop";  ///< or "warn", "smaller-step"
  std::optional<std::string> model;
  bool no_page = false;
  bool watch = false;  ///< serves the page while the run goes on
  std::optional<int> port;
  bool reproducible = false;  ///< exact sums, the same bits for any number of processes
  /// Parameters of the spring-dashpot model; unset entries leave the scene's choice.
  std::optional<double> stiffness, overlap, tangential_ratio, substep;
};

/// For proofs that steps have no solution, in all; a step takes a part of it.             [s]
constexpr double kProofSeconds = 20;
constexpr int kWatchPort = 8017;

/// A flag without effect would mislead.
void refuse_flags_of_the_other_model(const RunFlags& flags, Model model) {
  const SolverFlags& solver = flags.solver;
  if (model == Model::kSpringDashpot) {
    const char* flag = solver.name                         ? "--solver"
                       : solver.stop                       ? "--stop"
                       : solver.tol                        ? "--tol"
                       : solver.max_iterations             ? "--max-iterations"
                       : solver.warm_start                 ? "--warm-start"
                       : !solver.parameters.empty()        ? "a solver parameter"
                       : !flags.dump_problems.empty()      ? "--dump-problems"
                       : !flags.on_failure.empty()         ? "--on-failure"
                       : flags.on_tunnel == "smaller-step" ? "--on-tunnel smaller-step"
                       : flags.reproducible                ? "--reproducible"
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

/// Applies the command line's changes, and checks the result before anything is written.
template <int D>
void apply_flags(const RunFlags& flags, Scene<D>& scene) {
  if (flags.steps && flags.duration) {
    throw std::invalid_argument("give --steps or --duration: one decides the other");
  }
  if (flags.step_size) scene.step = *flags.step_size;
  if (flags.watch && flags.no_page) {
    throw std::invalid_argument("--watch shows the page that --no-page leaves out: give one");
  }
  if (flags.port && !flags.watch) throw std::invalid_argument("--port goes with --watch");
  if (flags.no_page) scene.output.page = false;
  if (flags.watch) scene.output.page = true;
  scene.solver = merged(scene.solver, flags.solver);
  if (flags.model) scene.model = *flags.model == "dem" ? Model::kSpringDashpot : Model::kNonsmooth;
  refuse_flags_of_the_other_model(flags, scene.model);
  if (flags.stiffness) scene.dem.stiffness = *flags.stiffness;
  if (flags.overlap) {
    scene.dem.overlap = *flags.overlap;
    scene.dem.stiffness = 0;
  }
  if (flags.tangential_ratio) scene.dem.tangential_ratio = *flags.tangential_ratio;
  if (flags.substep) scene.dem.substep = *flags.substep;
  if (scene.model == Model::kSpringDashpot &&
      scene.contact_distance != default_contact_distance(scene)) {
    const std::string_view key = "[contact] distance";
    const std::size_t of_rigid = scene.caution.find(key);  // the last caution of a file
    scene.caution.resize(std::min(of_rigid, scene.caution.size()));
    const char* and_then = scene.caution.empty() || of_rigid != std::string::npos ? "" : "; ";
    scene.caution += fmt::format("{}{} is left out: springs need none", and_then, key);
  }
  if (auto defect = validate(scene); !defect.empty()) throw std::invalid_argument(defect);
}

/// Says so where flags change the time that the scene would simulate, else nothing.
template <int D>
std::string changed_time(double planned, const Scene<D>& scene, const State<D>& state) {
  const double ends = state.time + scene.step * (scene.num_steps - state.step);
  if (std::abs(ends - planned) <= 0.6 * scene.step) return {};
  return fmt::format("the run ends at t = {:.6g} s, the scene at {:.6g} s", ends, planned);
}

/// Output that the flags ask for.
RunFolderOptions folder_options(const RunFlags& flags, const std::string& scene_text) {
  using Problems = RunFolderOptions::Problems;
  const fs::path folder = flags.common.out;
  return {.folder = folder,
          .scene_text = scene_text,
          .program = "bipot " + program_version(),
          .resume = !flags.restart.empty() && fs::exists(folder) &&
                    fs::equivalent(folder, run_folder(flags.restart)),
          .problems = flags.dump_problems == "all"      ? Problems::kAll
                      : flags.dump_problems == "failed" ? Problems::kFailed
                                                        : Problems::kNone};
}

/// Makes the folder of the results and holds it. Throws std::invalid_argument if another run writes
/// into it, or if an earlier one lies there and the flags do not say what becomes of it.
std::unique_ptr<FolderLock> claim_folder(const RunFlags& flags, const RunFolderOptions& options) {
  const fs::path& folder = options.folder;
  if (flags.overwrite && options.resume) {
    throw std::invalid_argument("--restart goes on in " + folder.string() +
                                ", --overwrite would delete it: give one");
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw FileError(folder, "", "cannot create: " + error.message());
  auto lock = std::make_unique<FolderLock>(folder);
  const std::vector<int> steps = steps_in_folder(folder);
  if (!steps.empty() && !options.resume && !flags.overwrite) {
    throw std::invalid_argument(
        fmt::format("{} holds a run of {} steps: --restart {} or --overwrite", folder.string(),
                    steps.back(), folder.string()));
  }
  if (!options.resume && (!steps.empty() || fs::exists(folder / "run.h5"))) remove_run(folder);
  return lock;
}

/// True for a run that ended after its last frame, before its pictures, charts and summary.
bool lacks_results(const fs::path& folder, int last_step) {
  const fs::path path = folder / "summary.json";
  if (!fs::exists(path)) return true;
  const Json summary = Json::parse(read_text_file(path), nullptr, false);
  return !summary.is_object() || summary.value("last_step", Json()) != Json(last_step) ||
         summary.value("status", Json()) == Json("interrupted");
}

/// True if the ledger has each of these steps, solved.
bool all_solved(const fs::path& folder, int steps) {
  if (steps == 0) return true;
  if (!fs::exists(folder / "ledger.csv")) return false;
  std::istringstream ledger(read_text_file(folder / "ledger.csv"));
  std::string line;
  std::getline(ledger, line);
  const std::vector<std::string> names = split_csv_line(line);  // a column may have texts
  const auto converged = to_size(std::ranges::find(names, "converged") - names.begin());
  int solved = 0;
  while (std::getline(ledger, line)) {
    const std::vector<std::string> row = split_csv_line(line);
    solved += converged < row.size() && row[0] != "0" && row[converged] == "1" ? 1 : 0;
  }
  return solved == steps;
}

/// A run that was complete already. Its files do not change.
template <int D>
int nothing_to_do(const RunFlags& flags, const Scene<D>& scene, const State<D>& state, bool quiet) {
  const std::string message =
      state.step < scene.num_steps
          ? fmt::format("{} is at step {} of {}: no step is asked for", flags.restart, state.step,
                        scene.num_steps)
          : fmt::format(
                "{} is at step {}, the scene ends at step {}: nothing to do (--steps N takes "
                "N more)",
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

/// A page that cannot be written costs nothing else.
void write_page_or_say(const fs::path& folder) {
  try {
    write_run_page(folder);
  } catch (const std::exception& e) {
    say("bipot: the page of the run is not written: {}\n", e.what());
  }
}

/// False: charts cannot be drawn, which costs nothing else.
bool can_draw(bool quiet) {
  try {
    require_plotting_tool();
    return true;
  } catch (const FileError& e) {
    if (!quiet) say("bipot: warning: charts are left out: {}\n", e.what());
    return false;
  }
}

struct RunOutcome {
  std::string status;
  ExitCode exit_code;
};

template <int D>
RunOutcome outcome_of(const SceneRun<D>& run, bool has_begun, bool interrupted) {
  using End = typename SceneRun<D>::End;
  if (run.end == End::kFailed) {
    using Kind = StepFailure::Kind;
    switch (run.failure->kind) {
      case Kind::kInvalidInput:
        if (has_begun) return {"failed", kExitNumericalFailure};
        return {"invalid input", kExitBadInput};
      case Kind::kNotConverged:
        return {"not converged", kExitNotConverged};
      case Kind::kUnsolvable:
        return {"no solution", kExitNumericalFailure};
      case Kind::kPassage:
        return {"passed through", kExitNumericalFailure};
      case Kind::kNumerical:
      case Kind::kPlaces:
      case Kind::kCutShort:
        return {"failed", kExitNumericalFailure};
    }
  }
  if (interrupted) return {"interrupted", kExitInterrupted};
  if (run.end == End::kCancelled) return {"time limit", kExitNotConverged};
  if (run.totals.converged < run.totals.steps) return {"not converged", kExitNotConverged};
  return {"completed", kExitConverged};
}

/// A run before its first step.
template <int D>
struct PreparedRun {
  Scene<D> scene;
  State<D> state;
  SceneRunOptions<D> options;
  std::unique_ptr<FolderLock> lock;     // of the folder of the results, on the speaker
  std::unique_ptr<WatchServer> server;  // likewise, with --watch
  StartReport start;
  bool finished = false;    // before, with all its results
  std::string note;         // on the simulated time
  std::string whole_state;  // reason why this process has the whole state; empty: it has a part
};

/// Reads and checks, up to the last refusal before a result is written; the folder is made. `text`:
/// of the scene's file.
template <int D>
PreparedRun<D> prepare_run(const RunFlags& flags, Scene<D> scene, const std::string& text) {
  PreparedRun<D> run;
  refuse_on_several_processes(flags.common, "");
  const double planned = scene.step * scene.num_steps;
  apply_flags(flags, scene);
  run.scene = std::move(scene);
  SceneRunOptions<D>& options = run.options;
  options.threads = flags.common.threads;
  options.on_failure = flags.on_failure == "stop"           ? OnFailure::kStop
                       : flags.on_failure == "smaller-step" ? OnFailure::kSmallerStep
                       : flags.on_failure == "continue"     ? OnFailure::kContinue
                                                            : OnFailure::kUnlessUnsolvable;
  options.proof_seconds = kProofSeconds;
  options.on_tunnel = flags.on_tunnel == "warn"           ? OnTunnel::kWarn
                      : flags.on_tunnel == "smaller-step" ? OnTunnel::kSmallerStep
                                                          : OnTunnel::kStop;
  options.cancelled = &InterruptGuard::requested;
  options.time_limit = flags.common.time_limit;
  options.reproducible = flags.reproducible;
  if (on_several_processes() || flags.reproducible) options.processes = &run_processes();
  const SceneStepper<D> refuses(run.scene, options);
  options.folder = folder_options(flags, text);
  if (!flags.restart.empty()) {
    run.state = read_state<D>(flags.restart);
    if (const std::string mismatch = restart_mismatch(run.scene, run.state); !mismatch.empty()) {
      throw std::invalid_argument(flags.restart + " does not fit the scene: " + mismatch);
    }
  }
  options.steps =
      flags.steps ? *flags.steps : remaining_steps(run.scene, run.state, flags.duration);
  const bool ended = !flags.restart.empty() && *options.steps == 0;
  const bool asked = flags.steps || flags.duration || !options.folder.resume;
  run.finished = ended && (asked || !lacks_results(options.folder.folder, run.state.step));
  if (run.finished) return run;
  run.scene.num_steps = run.state.step + *options.steps;
  run.note = ended ? "no step was left: results of the ended run; steps without a solved row count "
                     "as unsolved"
                   : changed_time(planned, run.scene, run.state);
  if (is_speaker()) {
    if (flags.watch) run.server = std::make_unique<WatchServer>(flags.port.value_or(kWatchPort));
    run.lock = claim_folder(flags, options.folder);
  }
  if (flags.restart.empty()) {
    const fs::path picture = is_speaker() ? options.folder.folder / "start.png" : fs::path();
    std::error_code no_matter;
    if (is_speaker()) fs::remove(picture, no_matter);
    // The clocks of several processes differ, and all push apart.
    const double limit = on_several_processes() ? kInfinity : options.time_limit;
    run.start = check_start(run.scene, picture, options.threads, limit);
    run.state = initial_state(run.scene);
  }
  run.whole_state = needs_whole_state(run.scene, options);
  return run;
}

/// The steps of a run, and their messages.
template <int D>
struct TakenSteps {
  SceneRun<D> run;
  std::string advice;  // on the first step that was not solved
  std::string warning;
};

template <int D>
TakenSteps<D> take_steps(PreparedRun<D>& prepared, bool quiet) {
  Scene<D>& scene = prepared.scene;
  State<D>& state = prepared.state;
  SceneRunOptions<D>& options = prepared.options;
  const bool smaller_steps = options.on_failure == OnFailure::kSmallerStep;
  const bool speaks = is_speaker() && !quiet;
  TakenSteps<D> taken;
  EnergyGrowth growth(scene, state);
  const bool can_cut = scene.model == Model::kNonsmooth && !smaller_steps;
  RunProgress progress(
      *options.steps,
      {.quiet = !speaks,
       .folder = is_speaker() ? options.folder.folder : fs::path(),
       .resume = options.folder.resume,
       .step = state.step,
       .time = state.time,
       .tol = scene.solver.tol,
       .hint = can_cut ? "--on-failure smaller-step takes such a step in parts; --time-limit "
                         "SECONDS ends the run"
                       : "--time-limit SECONDS ends the run"});
  if (scene.solver.stop == "guarded") {  // else its tolerance is that of another error
    options.on_iteration = [&progress](const IterationRecord& record) { progress.judged(record); };
  }
  options.on_step = [&, first = state.step](const SceneStep<D>& step) {
    const StepReport<D>& report = step.report;
    growth.add(scene, report);
    if (!report.converged && taken.advice.empty() && speaks) {
      taken.advice = failure_text<D>(scene, step.state, step.state.contacts, step.problem,
                                     report.error, report.step, smaller_steps, report.message);
    }
    progress.add(report, report.step - first, step.state.time);
    return true;
  };
  if (prepared.server) {
    // From the first step on the folder is that of this run.
    options.before_step = [&, serves = false](State<D>&) mutable {
      if (std::exchange(serves, true)) return;
      prepared.server->serve(options.folder.folder);
      say("watch the run: {}\n", prepared.server->address());
    };
  }
  // The root process needs the bodies of the scene for its files.
  if (prepared.whole_state.empty() && !is_speaker()) scene.bodies = {};
  taken.run = run_scene(scene, state, options);
  taken.warning = growth.warning(scene) + motion_warning(scene, taken.run.totals);
  return taken;
}

/// `text`: of the scene's file.
template <int D>
int run_in(const RunFlags& flags, Scene<D> given, const std::string& text) {
  const Stopwatch watch;
  PreparedRun<D> prepared;
  const bool quiet = flags.common.quiet || flags.common.json == "-";
  together([&] { prepared = prepare_run(flags, std::move(given), text); });
  const Scene<D>& scene = prepared.scene;
  const State<D>& state = prepared.state;
  const fs::path& folder = prepared.options.folder.folder;
  if (prepared.finished) {
    return is_speaker() ? nothing_to_do(flags, scene, state, quiet) : int{kExitConverged};
  }
  bool draws = false;
  together([&] {
    if (!is_speaker()) return;
    if (scene.observables) draws = can_draw(flags.common.quiet);
    require_writable(flags.common.json);  // may lie in the folder that was just made
  });

  if (!flags.common.quiet) {
    if (const std::string walls = unbalanced_walls(scene); !walls.empty()) {
      say("bipot: warning: {}", walls);
    }
    warn_once(scene.caution);
  }
  const InterruptGuard interrupt;
  prepared.options.time_limit -= watch.seconds();
  TakenSteps<D> taken = take_steps(prepared, quiet);
  const SceneRun<D>& run = taken.run;
  double peak_and_interrupt[2] = {peak_memory(), InterruptGuard::requested() ? 1.0 : 0.0};
  if (on_several_processes()) run_processes().largest(peak_and_interrupt);
  const auto [peak, interrupted] = peak_and_interrupt;
  auto [status, exit_code] = outcome_of(run, prepared.state.step > 0, interrupted > 0);
  if (*prepared.options.steps == 0 && exit_code == kExitConverged &&
      !all_solved(folder, state.step)) {  // or not known to be
    std::tie(status, exit_code) = std::pair("not converged", kExitNotConverged);
  }
  if (!is_speaker()) return exit_code;
  if (scene.observables) write_observable_charts(folder, scene.observables->profile, draws);
  if (run.failure) {
    say("bipot: {}\n", short_reason(run.failure->what()));
    using Kind = StepFailure::Kind;
    if (!quiet && run.failure->kind == Kind::kPassage) {
      taken.advice =
          passage_advice(scene, state, run.springs.get(), flags.on_tunnel == "smaller-step");
    } else if (!quiet && run.failure->kind != Kind::kPlaces &&
               run.failure->kind != Kind::kInvalidInput && run.failure->kind != Kind::kCutShort &&
               (exit_code == kExitNumericalFailure || exit_code == kExitNotConverged)) {
      taken.advice = failure_text(scene, state, run, flags.on_failure == "smaller-step");
      if (run.failure->kind == Kind::kUnsolvable) {
        taken.advice += "  --on-failure continue goes on with the best impulse\n";
      }
    }
  }
  const bool cut = run.failure ? run.failure->kind == StepFailure::Kind::kCutShort
                               : run.end == SceneRun<D>::End::kCancelled;
  if (cut && !quiet) taken.advice = fmt::format("  --restart {} goes on\n", folder.string());
  say("{}", taken.advice);
  if (!flags.common.quiet) say("{}", taken.warning);
  const RunSummary<D> summary{.scene = scene,
                              .state = state,
                              .run = run,
                              .status = status,
                              .exit_code = exit_code,
                              .wall_seconds = watch.seconds(),
                              .out = flags.common.out,
                              .start = prepared.start,
                              .note = prepared.note};
  Json json = to_json(summary);
  if (prepared.options.processes != nullptr) json["processes"] = launched_processes();
  std::string state_text;
  if (on_several_processes()) {
    state_text = run.domains ? "distributed" : "on every process: " + prepared.whole_state;
    json["state"] = state_text;
  }
  if (run.domains) json["domains"] = to_json(*run.domains, peak);
  json["command_line"] = typed_command();
  write_json(json, (folder / "summary.json").string());
  append_to_log(folder, to_text(summary));
  if (prepared.server) prepared.server->finish();
  if (scene.output.page) write_page_or_say(folder);
  if (!flags.common.json.empty()) write_json(json, flags.common.json);
  if (!quiet) {
    fmt::print("{}", to_text(summary));
    if (!state_text.empty()) {
      fmt::print("  processes    {}, state {}\n", launched_processes(), state_text);
    }
    if (run.domains) fmt::print("{}", to_text(*run.domains));
  }
  return exit_code;
}

CommandDeclaration add_run(CommandLine& line, RunFlags& flags) {
  CommandDeclaration command =
      line.add_command("run", "Run a scene: time steps, files, pictures, summary");
  command.option("scene", flags.scene, "Scene file (TOML) or the name of a shipped scene",
                 {.required = true, .suggest = names_of(shipped_scenes())});
  command.option("--steps N", flags.steps,
                 "Number of steps instead of the scene's; with --restart: more steps",
                 {.not_negative = true});
  command.option("--step-size SECONDS", flags.step_size,
                 "Time step instead of the scene's, whose duration (or steps) stays",
                 {.positive = true});
  command.option("--accuracy RADII", flags.accuracy,
                 "Steps are cut: impacts misplace a body by fewer radii; 0: they are not",
                 {.not_negative = true});
  command.option("--duration SECONDS", flags.duration,
                 "Time to simulate, instead of the scene's; with --restart: more time",
                 {.positive = true});
  command.option("--restart RUN", flags.restart,
                 "Go on from the last frame of that run (folder or run.h5)");
  command.option("--model", flags.model,
                 "nscd: rigid, one contact problem a step; dem: springs and dashpots",
                 {.one_of = {"nscd", "dem"}});
  const auto dem = [&](const char* name, std::optional<double>& value, const char* help) {
    command.option(name, value, help, {.group = "Model dem"});
  };
  dem("--stiffness N/m", flags.stiffness, "Normal stiffness (default: by --overlap)");
  dem("--overlap FRACTION", flags.overlap,
      "Overlap aimed at, of the smallest radius: decides the stiffness");
  dem("--tangential-ratio FRACTION", flags.tangential_ratio, "Tangential over normal stiffness");
  dem("--substep SECONDS", flags.substep, "Largest substep (default: from the stability limit)");
  command.flag("--no-page", flags.no_page, "No index.html, which plays the run",
               {.group = "Results"});
  command.flag("--watch", flags.watch, "Serve the page to this machine while the run goes on",
               {.group = "Results"});
  command.option("--port N", flags.port, fmt::format("Of --watch; 0: any (default {})", kWatchPort),
                 {.group = "Results", .between = {{0, 65535}}});
  add_reproducible_flag(command, flags.reproducible);
  add_common_flags(command, flags.common, "Folder for the results (out/SCENE)");
  command.flag("--overwrite", flags.overwrite, "Delete the run that DIR holds");
  command.option("--dump-problems", flags.dump_problems,
                 "Write the steps' contact problems as FCLIB files into DIR/problems",
                 {.group = "Results", .one_of = {"all", "failed"}});
  command.option("--on-failure WORD", flags.on_failure,
                 "Unsolved step; default: continue, unless it provably has no solution",
                 {.one_of = {"continue", "stop", "smaller-step"}});
  command.option("--on-tunnel WORD", flags.on_tunnel,
                 "After bodies went through each other or a wall; default: stop",
                 {.one_of = {"stop", "warn", "smaller-step"}});
  add_solver_flags(command, flags.solver);
  add_warm_start_flags(command, flags.solver);
  command.footer(
      "Examples:\n"
      "  bipot run my.toml --out out/a && bipot run my.toml --restart out/a --steps 100");
  return command;
}

int start_run(const RunFlags& given) {
  RunFlags flags = given;
  std::string text;
  AnyScene scene;
  together([&] {
    const fs::path path = find_scene(flags.scene);
    if (flags.common.out.empty()) {
      flags.common.out = flags.restart.empty() ? (fs::path("out") / path.stem()).string()
                                               : run_folder(flags.restart).string();
    }
    text = read_text_file(path);
    scene = parse_any_scene(text, path.string(), flags.accuracy);
  });
  return std::visit([&](auto&& any) { return run_in(flags, std::move(any), text); },
                    std::move(scene));
}

}  // namespace

ProgramCommand run_command(CommandLine& line) { return make_command(line, &add_run, &start_run); }

}  // namespace bipot
