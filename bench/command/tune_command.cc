#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/command/commands.h"
#include "bench/command/exit_code.h"
#include "bench/command/progress_bar.h"
#include "bench/command/tune_run.h"
#include "bench/measure/problem_target.h"
#include "bench/report/document.h"
#include "bench/report/json_output.h"
#include "bench/tune/tuned_plan.h"
#include "core/base/interrupt.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

struct TuneFlags {
  std::vector<std::string> targets, solvers;
  std::vector<double> tols;
  double time_limit = 2;  ///< CPU seconds of one solve
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
  command.option("--tols NUMBERS", flags.tols, "Tolerances (1e-2,1e-4,1e-8)").positive();
  command.option("--time-limit SECONDS", flags.time_limit, "CPU seconds of one solve")
      .positive()
      .show_default();
  command.option("--scene-problems", flags.scene_problems, "Steps of a scene or a moving family")
      .between(1, 1000)
      .show_default();
  command.option("--least-rows", flags.least_rows, "Solves behind a class of the plan, at least")
      .between(1, 100000)
      .show_default();
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
  MeasureOptions options{.variants = tuned_variants(flags.solvers)};
  if (!flags.tols.empty()) options.tols = flags.tols;
  options.time_limit = flags.time_limit;
  options.file = flags.rows;
  const std::filesystem::path plan =
      flags.out.empty() ? default_plan_file(flags.targets) : std::filesystem::path(flags.out);
  return tune_targets(flags.targets, {.scene_problems = flags.scene_problems}, std::move(options),
                      flags.least_rows, plan, flags.quiet);
}

}  // namespace

std::filesystem::path default_plan_file(const std::vector<std::string>& targets) {
  const std::filesystem::path first = targets.size() == 1 ? targets.front() : "";
  return first.extension() == ".toml" ? first.parent_path() / "plan.toml" : "plan.toml";
}

int tune_targets(const std::vector<std::string>& targets, const TargetOptions& scenes,
                 MeasureOptions options, int least_rows, const std::filesystem::path& plan,
                 bool quiet) {
  require_writable(plan.string());
  if (options.file.empty()) {
    options.file = plan;
    options.file.replace_extension(".csv");
  }
  const std::vector<ProblemSource> sources = expand_targets(targets, scenes);
  const InterruptGuard interrupt;
  options.interrupted = &InterruptGuard::requested;
  const long solves = static_cast<long>(2 * sources.size() * (options.variants.size() + 1));
  std::vector<MeasuredRow> rows;
  {
    ProgressBar progress(solves, quiet);
    options.on_row = [&](const std::string& what, int done, int) { progress.update(done, what); };
    rows = measure_rows(sources, options);
  }
  if (InterruptGuard::requested()) {
    fmt::print(stderr, "bipot: stopped; the same command goes on from {}\n", options.file.string());
    return kExitInterrupted;
  }
  const TunedPlan made = tune_plan(rows, options.variants, least_rows);
  if (made.classes.empty()) {
    throw std::invalid_argument(options.file.string() + ": no solver solved any of the problems");
  }
  const std::string commit = provenance("tune", typed_command()).build.commit;
  write_text_file(plan.string(),
                  plan_text(made, fmt::format("# {}\n# {} rows; commit {}\n", typed_command(),
                                              rows.size(), commit)));
  if (!quiet) {
    fmt::print("{}\n{} classes in {}, {} rows in {}\n", regret_text(made), made.classes.size(),
               plan.string(), rows.size(), options.file.string());
  }
  return kExitConverged;
}

ProgramCommand tune_command(CommandLine& line) { return make_command(line, &add_tune, &run_tune); }

}  // namespace bipot
