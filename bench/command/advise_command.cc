#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/say.h"
#include "bench/command/tune_run.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/problems/scene_rewrite.h"
#include "bench/report/json_output.h"
#include "bench/tradeoff/advice.h"
#include "bench/tradeoff/advice_report.h"
#include "bench/tradeoff/advise.h"
#include "core/base/interrupt.h"
#include "core/base/types.h"
#include "core/files/atomic_file.h"
#include "core/files/input_file.h"
#include "core/scene_files/scene_file.h"
#include "solvers/simulation/scene_start.h"

namespace bipot {
namespace {

struct AdviseFlags : OutputFlags {
  std::string scene;
  Advice::Options options;
  std::vector<std::string> solvers;  ///< empty: the promising ones
  bool force_overwrite = false, all = false, tune = false;
  std::string write;
};

namespace fs = std::filesystem;

constexpr int kLeastRows = 6;  // solves behind a class of a tuned plan

int exit_code_of(Advice::Status status) {
  if (status == Advice::Status::kInterrupted) return kExitInterrupted;
  return status == Advice::Status::kMet || status == Advice::Status::kNoContacts
             ? kExitConverged
             : kExitNotConverged;
}

void write_scene(const AdviseFlags& flags, const std::string& text, const std::string& source,
                 const Advice& advice) {
  const Advice::SolverTrial& t = advice.trials[to_size(advice.choice)];
  const std::string written = rewrite_scene(
      text, source,
      {.step = advice.step_size,
       .num_steps = advice.num_steps,
       .accuracy = advice.accuracy,
       .solver = t.solver.solver,
       .parameters = t.solver.parameters,
       .tol = t.tol,
       .warm_start = advice.warm_start,
       .comment = fmt::format("bipot advise, {} ({})", error_text(advice.goal, advice.goal),
                              to_string(advice.status))});
  write_text_file(flags.write, written);
}

/// Checked before the work, not after it.
void check_destinations(const AdviseFlags& flags) {
  const auto refuse_file = [&](const fs::path& file, const char* otherwise) {
    if (flags.force_overwrite || file.empty() || !fs::exists(file)) return;
    throw std::invalid_argument(file.string() + " exists: " + otherwise + ", or give --force");
  };
  refuse_file(flags.write, "name another file");
  if (flags.tune) refuse_file(default_plan_file({flags.scene}), "move it");
  require_writable(flags.write);
  flags.prepare(true);
}

CommandDeclaration add_advise(CommandLine& line, AdviseFlags& flags) {
  CommandDeclaration command = line.add_command(
      "advise", "Which solver, tolerance and time step a scene needs, tried on the scene itself");
  command.option("scene", flags.scene, "Scene file (TOML) or the name of a shipped scene",
                 {.required = true, .suggest = names_of(shipped_scenes())});
  const auto goal = [&](const char* name, double& value, const char* help) {
    command.option(std::string(name) + " X", value, help, {.positive = true});
  };
  goal("--force-error", flags.options.goal.force,
       "Largest error of the mean contact force on a body, over the largest such force");
  goal("--penetration", flags.options.goal.penetration, "Largest overlap, over the smaller radius");
  goal("--energy", flags.options.goal.energy, "Largest relative error of the dissipated energy");
  goal("--load", flags.options.goal.load,
       "Largest error of the mean force on a wall, over the largest such force");
  goal("--coordination", flags.options.goal.coordination,
       "Largest relative error of the mean number of contacts of a body");
  goal("--stress-ratio", flags.options.goal.stress_ratio, "Largest relative error of the mean τ/P");
  command.option("--solvers NAMES", flags.solvers,
                 "Solvers to try, separated by commas (a selection)");
  command.option("--time-limit SECONDS", flags.options.time_limit, "Wall seconds for the trials",
                 {.show_default = true, .positive = true});
  command.option("--window SECONDS", flags.options.window,
                 "Time in s over which forces are averaged to judge the time step (a fiftieth of "
                 "the run, at least 16 steps)",
                 {.positive = true});
  command.option("--samples", flags.options.samples,
                 "Stretches of the run to choose on; more narrow the ±",
                 {.show_default = true, .between = {{1, 64}}});
  command.flag("--keep-step", flags.options.keep_step, "Keep the scene's time step");
  command.option("--write FILE", flags.write,
                 "Write a copy of the scene with the advice in it; comments and layout stay");
  command.flag("--force", flags.force_overwrite, "--write and --tune may overwrite a file");
  command.flag("--tune", flags.tune,
               "Then measure solvers on the scene's steps at the advised tolerance, and write a "
               "plan for auto: plan.toml beside the scene file");
  command.flag("--all", flags.all, "Print what was tried too, with its errors and costs");
  add_output_flags(command, flags, "Folder for advice.html, .csv and .json");
  command.footer(
      "Prints five lines: choice, expected error, cost, verdict, and the command that runs it.\n"
      "Without a goal it takes 5 % in overlaps and in means over time that the scene has: dissipated\n"
      "energy, loads on walls, τ/P in a periodic cell.\n"
      "Ends with 0 when the goal is met (or nothing touches), with 1 when it is not, or when time was\n"
      "too short to say: the message has the reason and the best that can be had.\n"
      "Examples:\n"
      "  bipot advise compaction\n"
      "  bipot advise my_scene.toml --force-error 1e-2 --energy 1e-2 --write advised.toml\n"
      "  bipot advise my_scene.toml --penetration 1e-3 --keep-step --json -");
  return command;
}

int run_advise(const AdviseFlags& flags) {
  check_destinations(flags);
  const fs::path path = find_scene(flags.scene);
  const std::string text = read_text_file(path);
  AnyScene scene = parse_any_scene(text, path.string());
  const std::function<void(const std::string&)> warn =
      flags.quiet ? nullptr : std::function(&warn_once);
  std::visit([&](auto& any) { check_start(any, warn); }, scene);
  Advice::Options options = flags.options;
  for (const std::string& name : flags.solvers) options.solvers.push_back({name, name, {}});
  // Refused before the work, not after it.
  if (flags.tune) tuned_variants(flags.solvers);
  const bool quiet = flags.silent();
  if (!quiet) options.say = [](const std::string& stage) { say("{} ...\n", stage); };
  const InterruptGuard interrupt;
  options.interrupted = &InterruptGuard::requested;
  Advice advice = advise(scene, options);
  advice.scene = flags.scene;
  const Provenance made = provenance("advise", typed_command());
  Json json = to_json(advice, made);
  json["exit_code"] = exit_code_of(advice.status);
  const fs::path folder = flags.out;
  if (!flags.out.empty()) {
    write_json(json, (folder / "advice.json").string());
    write_text_file(folder / "advice.csv", advice_csv(advice));
    write_text_file(folder / "advice.html", to_html(advice_document(advice, &made)));
  }
  flags.deliver(json, flags.all ? to_text(advice_document(advice)) : advice_summary(advice),
                (folder / "advice.html").string());
  if (advice.choice < 0 && (flags.tune || !flags.write.empty())) {
    say("bipot: no solver was chosen: neither a scene nor a plan is written\n");
  }
  if (!flags.write.empty() && advice.choice >= 0) {
    write_scene(flags, text, path.string(), advice);
    if (!quiet) fmt::print("advice written into {}\n", flags.write);
  }
  if (flags.tune && advice.choice >= 0 && advice.status != Advice::Status::kInterrupted) {
    const std::vector<std::string> targets{flags.scene};
    MeasureOptions measure{.variants = tuned_variants(flags.solvers),
                           .tols = {advice.trials[to_size(advice.choice)].tol}};
    const fs::path plan = default_plan_file(targets);
    const int tuned = tune_targets(targets, {}, std::move(measure), kLeastRows, plan, quiet);
    if (tuned != kExitConverged) return tuned;
    if (!quiet) fmt::print("{}\n", run_command_of(advice, plan.string()));
  }
  return exit_code_of(advice.status);
}

}  // namespace

ProgramCommand advise_command(CommandLine& line) {
  return make_command(line, &add_advise, &run_advise);
}

}  // namespace bipot
