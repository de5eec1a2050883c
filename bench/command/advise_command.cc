#include "bench/command/advise_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "bench/command/exit_code.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/problems/scene_rewrite.h"
#include "bench/report/json_output.h"
#include "bench/tradeoff/advice_report.h"
#include "bench/tradeoff/advise.h"
#include "core/base/file_error.h"
#include "core/base/interrupt.h"
#include "core/base/types.h"
#include "core/files/atomic_file.h"
#include "core/files/input_file.h"
#include "core/scene_files/scene_file.h"
#include "solvers/simulation/scene_start.h"

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

void write_scene(const AdviseFlags& flags, const std::string& text, const Scene<2>& scene,
                 const Advice& advice) {
  const SolverTrial& t = advice.trials[advice.choice];
  const std::string written = rewrite_scene(
      text, scene.source,
      {.step = advice.step_size,
       .num_steps = advice.num_steps,
       .solver = t.solver.solver,
       .parameters = t.solver.parameters,
       .tol = t.tol,
       .warm_start = t.warm,
       .comment = fmt::format("bipot advise, {} ({})", error_text(advice.goal, advice.goal),
                              to_string(advice.status))});
  write_text_file(flags.write, written);
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
  const std::string text = read_text_file(path);
  Scene<2> scene = parse_scene(text, path.string());
  check_start(scene, {}, 1);
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
    Json json = to_json(scene, advice, provenance("advise", typed_command()));
    json["exit_code"] = exit_code_of(advice.status);
    write_json(json, flags.json);
  }
  if (!quiet) fmt::print("{}", to_text(advice_document(scene, advice)));
  if (!flags.write.empty() && advice.choice >= 0) {
    write_scene(flags, text, scene, advice);
    if (!quiet) fmt::print("\nadvice written into {}\n", flags.write);
  }
  return exit_code_of(advice.status);
}

}  // namespace bipot
