#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bench/command/commands.h"
#include "bench/command/tune_run.h"

namespace bipot {
namespace {

struct TuneFlags {
  std::vector<std::string> targets, solvers;
  MeasureOptions options;
  int scene_problems = 6, least_rows = 20;
  std::string out, rows;
  bool quiet = false;
};

CommandDeclaration add_tune(CommandLine& line, TuneFlags& flags) {
  CommandDeclaration command =
      line.add_command("tune", "A plan for auto, computed from measured solves of your problems");
  command.option("targets", flags.targets,
                 "Problem files, folders of them, scenes, families, as for compare; none: the rows "
                 "that are there");
  command.option("--out FILE", flags.out,
                 "File for the plan (plan.toml, beside the scene if that is the target)");
  command.option(
      "--rows FILE", flags.rows,
      "CSV of the measured rows, added to; rows that are there are kept (the plan's name "
      "with .csv)");
  command.option("--solvers NAMES", flags.solvers, "Names separated by commas (all)");
  command.option("--tols NUMBERS", flags.options.tols, "Tolerances (1e-2,1e-4,1e-8)",
                 {.positive = true});
  command.option("--time-limit SECONDS", flags.options.time_limit, "CPU seconds of one solve",
                 {.show_default = true, .positive = true});
  command.option("--scene-problems", flags.scene_problems, "Steps of a scene or a moving family",
                 {.show_default = true, .between = {{1, 1000}}});
  command.option("--least-rows", flags.least_rows, "Solves behind a class of the plan, at least",
                 {.show_default = true, .between = {{1, 100000}}});
  command.flag("--quiet,-q", flags.quiet, "No progress, no table");
  command.footer(
      "A stopped measurement goes on from its rows.\n"
      "Examples:\n"
      "  bipot tune my_scene.toml\n"
      "  bipot run my_scene.toml --plan plan.toml\n"
      "  bipot tune problems/ pour:18 --tols 1e-3 --time-limit 10 --out plan.toml");
  return command;
}

int run_tune(const TuneFlags& flags) {
  MeasureOptions options = flags.options;
  options.variants = tuned_variants(flags.solvers);
  options.file = flags.rows;
  const std::filesystem::path plan =
      flags.out.empty() ? default_plan_file(flags.targets) : std::filesystem::path(flags.out);
  return tune_targets(flags.targets, {.scene_problems = flags.scene_problems}, std::move(options),
                      flags.least_rows, plan, flags.quiet);
}

}  // namespace

ProgramCommand tune_command(CommandLine& line) { return make_command(line, &add_tune, &run_tune); }

}  // namespace bipot
