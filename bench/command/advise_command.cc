#include "bench/command/advise_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "bench/command/exit_code.h"
#include "bench/command/interrupt.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/problems/scene_rewrite.h"
#include "bench/report/build_info.h"
#include "bench/report/json_output.h"
#include "bench/report/labels.h"
#include "bench/tradeoff/advice_json.h"
#include "bench/tradeoff/advise.h"
#include "core/base/file_error.h"
#include "core/base/types.h"
#include "core/files/atomic_file.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

int exit_code_of(Advice::Status status) {
  switch (status) {
    case Advice::Status::kMet:
    case Advice::Status::kNoContacts:
      return kExitConverged;
    case Advice::Status::kInterrupted:
      return kExitInterrupted;
    case Advice::Status::kNotMet:
      break;
  }
  return kExitNotConverged;
}

std::string goal_text(const Accuracy& goal) {
  std::string text;
  for (auto m : Accuracy::kMeasures) {
    if (std::isnan(goal.*m)) continue;
    text += fmt::format("{}{} {:g}", text.empty() ? "" : ", ", name_of(m), goal.*m);
  }
  return text;
}

/// As "force error 1.2e-03, energy error 3.4e-02", for the required and measured quantities.
std::string error_text(const Accuracy& error, const Accuracy& goal) {
  std::string text;
  for (auto m : Accuracy::kMeasures) {
    if (std::isnan(goal.*m)) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name_of(m),
                        std::isnan(error.*m) ? "not measured" : fmt::format("{:.1e}", error.*m));
  }
  return text;
}

std::string cell(double x) {
  if (std::isnan(x)) return "-";
  if (std::isinf(x)) return "failed";
  return fmt::format("{:.1e}", x);
}

void print_trials(const Advice& a) {
  const bool any_stretch = std::any_of(a.trials.begin(), a.trials.end(),
                                       [](const SolverTrial& t) { return t.stretches > 0; });
  fmt::print(
      "\nSolvers: worst error over {} steps of the run and mean CPU time of a solve, on the left "
      "on single\nsteps, on the right on stretches of {:g} s, where each step starts from the "
      "errors of the one before.\n*: nothing is better in both time and error. Left to the "
      "solver: {}.\n",
      a.problems, a.steps.window, error_text(a.budget, a.goal));
  fmt::print("    {:<15} {:>6} {:<5} {:>8} {:>8} {:>8} {:>9}   {:>8} {:>8} {:>8} {:>9}\n", "solver",
             "tol", "start", "force", "penetr.", "energy", "time", "force", "penetr.", "energy",
             "time");
  int others = 0;
  for (std::size_t i = 0; i < a.trials.size(); ++i) {
    const SolverTrial& t = a.trials[i];
    const bool tried = t.stretches > 0;
    if (any_stretch && t.verdict == SolverTrial::Verdict::kNone &&
        static_cast<int>(i) != a.choice) {
      ++others;
      continue;
    }
    std::string note;
    if (t.solved < t.problems) note = fmt::format("  solved {} of {}", t.solved, t.problems);
    if (!tried && t.verdict == SolverTrial::Verdict::kStretchMissed) note += "  " + t.message;
    fmt::print("  {}{} {:<15} {:>6.0e} {:<5} {:>8} {:>8} {:>8} {:>9}   {:>8} {:>8} {:>8} {:>9}{}\n",
               static_cast<int>(i) == a.choice ? ">" : " ", t.pareto ? "*" : " ", t.solver.label,
               t.tol, t.warm ? "warm" : "cold", cell(t.error.force), cell(t.error.penetration),
               cell(t.error.energy), duration_label(t.seconds), cell(tried ? t.stretch.force : NAN),
               cell(tried ? t.stretch.penetration : NAN), cell(tried ? t.stretch.energy : NAN),
               tried ? duration_label(t.run_seconds) : "-", note);
  }
  if (others > 0) {
    fmt::print("  {} more trials were too inaccurate or too slow for stretches; --json has them\n",
               others);
  }
}

void print_steps(const Scene<2>& scene, const Advice& a) {
  if (a.steps.steps.empty()) {
    fmt::print("\nTime step: not measured; time was up or solves failed.\n");
    return;
  }
  fmt::print(
      "\nTime step: error that the step alone makes, solved tightly, over {} stretch{} of {:g} s, "
      "against steps of\n{:g} s. Force: mean over the stretch; penetration: added by a step, over "
      "the smallest radius.\n",
      a.steps.windows, a.steps.windows == 1 ? "" : "es", a.steps.window,
      a.steps.finest * scene.step);
  fmt::print("     {:>10} {:>8} {:>8} {:>8}\n", "step (s)", "force", "penetr.", "energy");
  for (std::size_t i = 0; i < a.steps.steps.size(); ++i) {
    const StepTrial& t = a.steps.steps[i];
    fmt::print("   {} {:>10g} {:>8} {:>8} {:>8}{}\n",
               static_cast<int>(i) == a.step.index ? ">" : " ", t.step, cell(t.error.force),
               cell(t.error.penetration), cell(t.error.energy),
               t.factor == 1 ? "  the scene's" : "");
  }
}

void print_confidence(const Advice& a) {
  fmt::print("\nHow far to trust it:\n");
  fmt::print("  the scene ran for {} of {} steps, {} with contacts (at most {}){}\n",
             a.sample.steps_run, a.sample.steps_planned, a.sample.contact_steps,
             a.sample.contacts_max, a.sample.note.empty() ? "" : "; " + a.sample.note);
  if (a.fresh.problems > 0) {
    fmt::print("  steps that it was chosen on: {}; the worst on {} others: {}\n", a.problems,
               a.fresh.problems, error_text(a.fresh.error, a.goal));
  } else {
    fmt::print("  steps that it was chosen on: {}; no others were solved to verify it\n",
               a.problems);
  }
  if (a.whole_windows > 0) {
    fmt::print("  the advice as a whole, on {} other stretches, against the finest steps: {}\n",
               a.whole_windows, error_text(a.whole_window, a.goal));
  }
  fmt::print("  references: guarded error at most {:.0e}; two solvers agree to {:.0e}\n",
             a.worst_reference, a.reference_spread);
  if (a.several_solutions > 0) {
    fmt::print(
        "  steps with several exact answers: {}, apart by at most {}; errors there are distances\n"
        "  to the nearest answer, and nothing below half of that counts\n",
        a.several_solutions, error_text(a.spread, a.goal));
  }
  if (share_of(a.stretch_spread, a.goal) > 0) {
    fmt::print("  two tight runs of the same stretches, started differently: {}\n",
               error_text(a.stretch_spread, a.goal));
  }
  if (a.without_reference > 0) {
    fmt::print("  steps left out because no solver got far enough below the goal in time: {}\n",
               a.without_reference);
  }
  if (a.steps.windows_dropped > 0 || (a.steps.finest > 0.125 && a.steps.finest > 0)) {
    fmt::print(
        "  time was short for the step study ({} stretches dropped, finest step {:g} of the "
        "scene's): --time-limit gives more\n",
        a.steps.windows_dropped, a.steps.finest);
  }
}

void print(const Scene<2>& scene, const Advice& a) {
  fmt::print("{}\n", scene.title.empty() ? scene.source : scene.title);
  fmt::print("  asked for   {}\n", goal_text(a.goal));
  fmt::print("  status      {}: {}\n", to_string(a.status), a.message);
  if (a.choice < 0) return;
  const SolverTrial& t = a.trials[a.choice];
  const bool own_step = std::abs(a.step_size / scene.step - 1) < 1e-9;
  fmt::print("  advice      {} to {:.0e}, {} start, time step {:g} s{}\n", t.solver.label, t.tol,
             t.warm ? "warm" : "cold", a.step_size,
             own_step ? " (the scene's)" : fmt::format(" (the scene's: {:g} s)", scene.step));
  fmt::print("  error       time step: {}\n", error_text(a.step_error, a.goal));
  fmt::print("              solver:    {}\n", error_text(worst_of(t.error, t.stretch), a.goal));
  fmt::print("  cost        {} a step, {} for the {:g} s of the scene ({} steps), files aside\n",
             duration_label(a.seconds_per_step), duration_label(a.seconds_in_all),
             scene.num_steps * scene.step, a.num_steps);
  print_steps(scene, a);
  print_trials(a);
  print_confidence(a);
}

void write_scene(const AdviseFlags& flags, const std::string& text, const Scene<2>& scene,
                 const Advice& advice) {
  const SolverTrial& t = advice.trials[advice.choice];
  const std::string written =
      rewrite_scene(text, scene.source,
                    {.step = advice.step_size,
                     .num_steps = advice.num_steps,
                     .solver = t.solver.solver,
                     .parameters = t.solver.parameters,
                     .tol = t.tol,
                     .warm_start = t.warm,
                     .comment = fmt::format("bipot advise, {} ({})", goal_text(advice.goal),
                                            to_string(advice.status))});
  AtomicFile file(flags.write);
  std::ofstream out(file.draft(), std::ios::binary);
  out << written;
  out.close();
  if (!out) throw FileError(flags.write, "", "cannot be written");
  file.commit();
}

/// Checked before the work, not after it.
void check_destinations(const AdviseFlags& flags) {
  if (!flags.write.empty() && fs::exists(flags.write) && !flags.force_overwrite) {
    throw std::invalid_argument(flags.write + " exists: name another file, or give --force");
  }
  require_writable(flags.write);
  require_writable(flags.json);
}

}  // namespace

CommandDeclaration add_advise_command(CommandLine& line, AdviseFlags& flags) {
  CommandDeclaration command = line.add_command(
      "advise", "Which solver, tolerance and time step a scene needs, tried on the scene itself");
  command.option("scene", flags.scene, "Scene file (TOML) or the name of a shipped scene")
      .required();
  command
      .option("--force-error", flags.force,
              "Largest error of the contact force on a body, over the largest such force")
      .value_name("X");
  command
      .option("--penetration", flags.penetration,
              "Largest overlap that a step may add, over the smallest radius")
      .value_name("X");
  command.option("--energy", flags.energy, "Largest relative error of the dissipated energy")
      .value_name("X");
  command.option("--solvers", flags.solvers, "Solvers to try, separated by commas (a selection)")
      .value_name("NAMES");
  command.option("--time-limit", flags.time_limit, "Wall seconds for the trials")
      .positive()
      .show_default()
      .value_name("SECONDS");
  command
      .option("--window", flags.window,
              "Time in s over which forces are averaged to judge the time step (a fiftieth of "
              "the run, at least 16 steps)")
      .positive()
      .value_name("SECONDS");
  command.option("--samples", flags.samples, "Steps of the run to choose on")
      .between(1, 64)
      .show_default();
  command.option("--fresh", flags.fresh, "Further steps to verify on")
      .between(0, 32)
      .show_default();
  command.flag("--keep-step", flags.keep_step, "Keep the scene's time step");
  command
      .option("--write", flags.write,
              "Write a copy of the scene with the advice in it; comments and layout stay")
      .value_name("FILE");
  command.flag("--force", flags.force_overwrite, "--write may overwrite a file");
  command
      .option("--json", flags.json,
              "Write advice and evidence as JSON; '-' is standard output, with nothing else "
              "on it")
      .value_name("FILE");
  command.flag("--quiet,-q", flags.quiet, "Nothing on the terminal");
  command.footer(
      "Ends with 0 when the goal is met (or nothing touches), with 1 when it is not: the message\n"
      "says what stands in the way and the best that can be had.\n"
      "Examples:\n"
      "  bipot advise compaction --force-error 1e-1\n"
      "  bipot advise my_scene.toml --force-error 1e-2 --energy 1e-2 --write advised.toml\n"
      "  bipot advise my_scene.toml --penetration 1e-3 --keep-step --json -");
  return command;
}

int advise_command(const AdviseFlags& flags) {
  check_destinations(flags);
  const fs::path path = find_scene(flags.scene);
  std::ostringstream content;
  content << std::ifstream(path).rdbuf();
  const Scene<2> scene = parse_scene(content.str(), path.string());
  AdviseOptions options;
  options.goal = {flags.force.value_or(kNaN), flags.penetration.value_or(kNaN),
                  flags.energy.value_or(kNaN)};
  for (const std::string& name : flags.solvers) options.solvers.push_back({name, name, {}});
  options.time_limit = flags.time_limit;
  options.window = flags.window.value_or(0);
  options.samples = flags.samples;
  options.fresh = flags.fresh;
  options.keep_step = flags.keep_step;
  const bool quiet = flags.quiet || flags.json == "-";
  if (!quiet) {
    options.say = [](const std::string& stage) { fmt::print(stderr, "{} ...\n", stage); };
  }
  const InterruptGuard interrupt;
  options.interrupted = &InterruptGuard::requested;
  const Advice advice = advise(scene, options);
  if (!flags.json.empty()) {
    Json json{{"command", "advise"}};
    json.update(to_json(scene, advice));
    json["exit_code"] = exit_code_of(advice.status);
    write_json(json, flags.json);
  }
  if (!quiet) print(scene, advice);
  if (!flags.write.empty() && advice.choice >= 0) {
    write_scene(flags, content.str(), scene, advice);
    if (!quiet) fmt::print("\nadvice written into {}\n", flags.write);
  }
  return exit_code_of(advice.status);
}

}  // namespace bipot
