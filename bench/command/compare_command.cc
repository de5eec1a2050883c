#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/say.h"
#include "bench/command/watched.h"
#include "bench/compare/comparison.h"
#include "bench/compare/comparison_report.h"
#include "bench/compare/popular_settings.h"
#include "bench/compare/settings_report.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/report/json_output.h"
#include "bench/report/labels.h"
#include "bench/tradeoff/trade_report.h"
#include "core/files/atomic_file.h"
#include "solvers/registry.h"
#include "solvers/solver.h"

namespace bipot {
namespace {

struct CompareFlags : OutputFlags {
  std::vector<std::string> targets;
  Comparison::Options options = {.solvers = {"all"}, .tols = {}};
  std::optional<double> time_limit;            ///< of one solve, 2 s; quick 1 s
  std::optional<double> reference_time_limit;  ///< of one attempt, 5 s; quick 3 s
  std::optional<int> scene_problems;           ///< 3; quick 1
  std::optional<int> scene_steps;              ///< all; quick 100
  /// Scenes run as a whole, beside the problems; "set": the set of `bipot trade`.
  std::vector<std::string> whole_runs;
  std::string settings;  ///< "popular"
  bool quick = false;
};

CommandDeclaration add_compare(CommandLine& line, CompareFlags& flags) {
  CommandDeclaration command = line.add_command(
      "compare", "Solvers on problems at tolerances: time against true error, as a report");
  command.option("targets", flags.targets,
                 "Problem file, folder of them, scene (my.toml, my.toml:steps=250), benchmark, or "
                 "family: square:30, "
                 "triangular:30, trapezoid:30, diluted:30, pyramid:20, random:20 (with "
                 ":mu=0.5:tilt=10:ratio=1e4:e=0.5:seed=2); pile:32, impact:32 (mu, tilt, seed); "
                 "moving pour:32, collapse:32, tilt:32 (its tilt: angle), strike:32, in space "
                 "pour3d:8, pipe:8, shear3d:8 (mu, tilt, e, seed); cannonballs:6, cubic:6 (mu, "
                 "tilt)");
  command.option("--settings NAME", flags.settings,
                 "In place of solvers and tolerances: defaults of popular codes, judged (targets: "
                 "the shipped problems)",
                 {.one_of = {"popular"}});
  command.option("--solvers NAMES", flags.options.solvers, "all, or names separated by commas");
  command.option("--tols NUMBERS", flags.options.tols,
                 "Tolerances (default 1e-2,1e-4,1e-6,1e-8; quick 1e-2,1e-6)", {.positive = true});
  command.option("--time-limit SECONDS", flags.time_limit, "CPU seconds of one solve (2; quick 1)",
                 {.positive = true});
  command.option("--reference-time-limit SECONDS", flags.reference_time_limit,
                 "CPU seconds of one attempt at a reference (5; quick 3)", {.positive = true});
  command.option("--repeat", flags.options.repeat, "Solves behind each time, at least",
                 {.show_default = true, .between = {{1, 1000}}});
  command.option("--min-time SECONDS", flags.options.min_time,
                 "CPU seconds for which short solves are repeated; the least time counts",
                 {.show_default = true, .not_negative = true});
  command.flag("--try-all", flags.options.try_all,
               "Run solvers also after they were out of time at a looser tolerance or on a "
               "smaller problem of the series");
  command.flag("--warm", flags.options.warm,
               "Beside each row the same from the step before, where known");
  command.option("--scene-problems", flags.scene_problems,
                 "Steps of a scene or a moving family (3; quick 1)", {.between = {{1, 1000}}});
  command.option("--scene-steps", flags.scene_steps, "Cut a scene's run there (no; quick 100)",
                 {.positive = true});
  command.option("--whole-runs SCENES", flags.whole_runs,
                 "Scenes to run as a whole too, by tolerance, time step and model, as `bipot "
                 "trade` does; 'set' is its own set");
  command.flag("--quick", flags.quick, "Loose limits and the small benchmark, for a first look");
  add_threads_flag(command, flags.options.threads);
  add_output_flags(
      command, flags,
      "Folder for rows.csv, history.csv, success.csv, several.csv, comparison.csv, "
      "comparison.json and report.html; a stopped comparison goes on from the rows there");
  command.footer(
      "Ends with 0 when the table is complete: solves that fail or run out of time are rows of "
      "it.\n"
      "Examples:\n"
      "  bipot compare square:30 pile:18 --out out/compare\n"
      "  bipot compare problems/ --solvers auto,pgs,ipm --tols 1e-8 --time-limit 60 --json -\n"
      "  bipot compare compaction --quick --out out/compaction_solvers\n"
      "  bipot compare --settings popular --out out/settings\n"
      "  bipot compare benchmark --whole-runs set --out out/benchmark");
  return command;
}

int run_settings(const CompareFlags& flags, const std::vector<ProblemSource>& sources) {
  const CompareFlags none;
  const std::pair<const char*, bool> others[] = {
      {"--solvers", flags.options.solvers != none.options.solvers},
      {"--tols", flags.options.tols != none.options.tols},
      {"--repeat", flags.options.repeat != none.options.repeat},
      {"--min-time", flags.options.min_time != none.options.min_time},
      {"--try-all", flags.options.try_all},
      {"--whole-runs", !flags.whole_runs.empty()},
      {"--threads", flags.options.threads != none.options.threads}};
  for (const auto& [name, given] : others) {
    if (given) throw std::invalid_argument(std::string(name) + " has no effect with --settings");
  }
  SettingStudy::Options options{.warm = flags.options.warm, .overlaps = flags.targets.empty()};
  options.time_limit = flags.time_limit.value_or(flags.quick ? 0.5 : options.time_limit);
  options.reference_time_limit = flags.reference_time_limit.value_or(options.reference_time_limit);
  flags.prepare(true);
  const SettingStudy study = watched(flags.silent(), [&, options](const Watch& watch) mutable {
    options.watch = watch;
    return study_settings(sources, options);
  });
  const Document summary = settings_document(study, provenance("compare", typed_command()));
  Document page = summary;
  page.fold("All runs", setting_rows(study), "rows");
  if (!flags.out.empty()) {
    const std::filesystem::path folder = flags.out;
    write_text_file(folder / "settings.csv", to_csv(setting_rows(study)));
    write_text_file(folder / "report.html", to_html(page));
    write_figures(folder, page);
  }
  flags.deliver(to_json(page), to_text(summary), "results in " + flags.out);
  return study.complete ? kExitConverged : kExitInterrupted;
}

/// True if s = 0 solves the problem.
bool nothing_to_solve(const Comparison& comparison, const Comparison::Problem& problem) {
  const auto solved = [&](const Comparison::Row& row) {
    return row.problem == problem.name && row.status == to_string(SolveStatus::kNothingToDo);
  };
  return std::ranges::any_of(comparison.rows, solved);
}

int run_compare(const CompareFlags& flags) {
  const InterruptGuard interrupt;
  Comparison::Options options = flags.options;
  options.out = flags.out;
  if (options.solvers == std::vector<std::string>{"all"}) options.solvers = solver_names();
  if (options.tols.empty()) {
    options.tols = flags.quick ? std::vector<double>{1e-2, 1e-6} : Comparison::Options{}.tols;
  }
  options.time_limit = flags.time_limit.value_or(flags.quick ? 1 : options.time_limit);
  options.reference_time_limit =
      flags.reference_time_limit.value_or(flags.quick ? 3 : options.reference_time_limit);
  TargetOptions scenes{.scene_problems = flags.scene_problems.value_or(flags.quick ? 1 : 3),
                       .quick = flags.quick};
  if (!flags.quiet) scenes.warn = &warn_once;
  scenes.scene_steps = flags.scene_steps.value_or(flags.quick ? 100 : scenes.scene_steps);
  if (flags.targets.empty() && flags.settings.empty()) {
    throw std::invalid_argument(
        "TARGETS is missing: problem files, scenes or families, in front of lists such as "
        "--solvers");
  }
  const std::vector<std::string> shipped = {(data_folder() / "problems").string()};
  const std::vector<ProblemSource> sources =
      expand_targets(flags.targets.empty() ? shipped : flags.targets, scenes);
  if (!flags.settings.empty()) return run_settings(flags, sources);

  std::optional<Trade::Options> trade;
  if (!flags.whole_runs.empty()) {
    trade = trade_options(flags.quick);
    if (flags.whole_runs != std::vector<std::string>{"set"}) trade->targets = flags.whole_runs;
    if (!flags.quiet) trade->warn = &warn_once;
    check_trade(*trade);
  }

  flags.prepare(true);
  const Comparison comparison = watched(flags.silent(), [&, options](const Watch& watch) mutable {
    options.watch = watch;
    return compare(sources, options);
  });
  std::optional<FinishedTrade> whole;
  if (trade && comparison.complete) {
    const std::string quick = flags.quick ? " --quick" : "";
    const bool set = flags.whole_runs == std::vector<std::string>{"set"};
    whole = watched(flags.silent(), [&](const Watch& watch) {
      trade->watch = watch;
      return finished_trade(
          *trade,
          fmt::format("bipot trade{}{}",
                      set ? "" : fmt::format(" {}", fmt::join(flags.whole_runs, " ")), quick),
          "bipot trade {}" + quick);
    });
  }

  ReportContext context{provenance("compare", typed_command()), typed_command(flags.targets),
                        options};
  context.made.threads = options.threads;
  if (!flags.out.empty()) {
    Document more;
    Json more_json = Json::object();
    if (whole) {
      write_trade(options.out, *whole);
      more.heading("Whole simulations", "whole");
      more.append(trade_document(*whole));
      more_json["whole_simulations"] = to_json(*whole);
    }
    write_report(options.out, comparison, context, more, &more_json);
  }
  Json table = to_json(comparison, context);
  std::string text = to_text(comparison);
  if (whole) {
    table["whole_simulations"] = to_json(*whole);
    text += "\nWhole simulations\n\n" + to_text(trade_document(*whole));
  }
  flags.deliver(
      table, text,
      fmt::format("results in {}{}", flags.out,
                  comparison.rows_kept == 0
                      ? ""
                      : fmt::format(", {} of {} rows from before", comparison.rows_kept,
                                    comparison.rows.size() + comparison.warm_rows.size())));
  bool any = comparison.problems.empty();
  for (const Comparison::Problem& p : comparison.problems) {
    any = any || p.defect.empty();
    if (!p.defect.empty()) say("bipot: {}: {}\n", p.name, p.defect);
    if (nothing_to_solve(comparison, p)) {
      say("bipot: {}: no impulse is needed there, which compares nothing{}\n", p.name,
          p.name.find('@') != std::string::npos
              ? "; other steps of the scene: --scene-steps, --scene-problems"
          : p.name.starts_with("random:") ? "; its disks are loose: pile has them at rest"
                                          : "");
    }
  }
  if (!any) return kExitBadInput;
  return comparison.complete && (!whole || whole->trade.complete) ? kExitConverged
                                                                  : kExitInterrupted;
}

}  // namespace

ProgramCommand compare_command(CommandLine& line) {
  return make_command(line, &add_compare, &run_compare);
}

}  // namespace bipot
