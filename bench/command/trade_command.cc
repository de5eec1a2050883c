#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "bench/command/command_options.h"
#include "bench/command/commands.h"
#include "bench/command/watched.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/tradeoff/trade_report.h"

namespace bipot {
namespace {

/// Empty entries take their default, or the smaller one of `quick`.
struct TradeFlags : OutputFlags {
  Trade::Options options = {
      .tols = {}, .step_factors = {}, .accuracies = {}, .overlaps = {}, .witness = "apgd"};
  std::optional<double> time_limit, negligible;
  std::optional<int> replicas;
  bool quick = false;
};

CommandDeclaration add_trade(CommandLine& line, TradeFlags& flags) {
  CommandDeclaration command = line.add_command(
      "trade", "Whole simulations: what a tolerance, a time step and springs cost and buy");
  command.option("scenes", flags.options.targets,
                 "Scene files or names of shipped scenes, each with :steps=N behind it for "
                 "another length (default: a set of them)",
                 {.suggest = names_of(shipped_scenes())});
  command.option("--solvers NAMES", flags.options.solvers,
                 "Solvers; the first one runs the time steps too", {.show_default = true});
  command.option("--tols NUMBERS", flags.options.tols,
                 "Tolerances (1e-1,1e-2,1e-3,1e-4,1e-6; quick 1e-1,1e-3)", {.positive = true});
  command.option("--step-factors FACTORS", flags.options.step_factors,
                 "Factors of the scene's time step (2,1,0.5,0.25; quick 2,1,0.5)",
                 {.positive = true});
  command.option("--accuracies RADII", flags.options.accuracies,
                 "Accuracies that cut steps of a frame, see run --accuracy (0.1,0.03; quick 0.1)",
                 {.positive = true});
  command.option(
      "--overlaps FRACTIONS", flags.options.overlaps,
      "Springs by the overlap aimed at, of the smallest radius (1e-2,1e-3,1e-4; quick 1e-2,1e-3)",
      {.positive = true});
  command.option("--stiffness N/m", flags.options.stiffness,
                 "Springs by their stiffness, instead of --overlaps", {.positive = true});
  command.option("--time-limit SECONDS", flags.time_limit, "CPU seconds of one run (20; quick 5)",
                 {.positive = true});
  command.option("--negligible", flags.negligible,
                 "Relative error of an outcome that is good enough in any case (1e-4)",
                 {.not_negative = true});
  command.option("--replicas", flags.replicas,
                 "Nearby runs of each setting where disks fly freely (3; quick 2)",
                 {.between = {{1, 1000}}});
  command.option(
      "--witness NAME",
      [&flags](const std::string& name) {
        flags.options.witness = name == "none" ? std::string() : name;
      },
      "Solver that runs the tightest tolerance too, to see what several exact answers do "
      "(apgd; none)");
  command.flag("--quick", flags.quick, "Fewer scenes and settings for a first look");
  add_output_flags(command, flags, "Folder for trade.csv, trade.json and trade.html");
  command.footer(
      "Ends with 0 when everything was run: runs that fail or take too long are rows of it.\n"
      "Examples:\n"
      "  bipot trade --out out/trade\n"
      "  bipot trade my_scene.toml --tols 1e-1,1e-2,1e-3,1e-5 --time-limit 60 --out out/mine\n"
      "  bipot trade square_lattice:steps=300 --solvers auto,pgs --overlaps 1e-3,1e-5");
  return command;
}

Trade::Options options_of(const TradeFlags& flags) {
  Trade::Options options = flags.options;
  if (!options.overlaps.empty() && !options.stiffness.empty()) {
    throw std::invalid_argument("give --overlaps or --stiffness: one decides the other");
  }
  const Trade::Options preset = trade_options(flags.quick);
  if (options.targets.empty()) options.targets = preset.targets;
  for (const auto list : {&Trade::Options::tols, &Trade::Options::step_factors,
                          &Trade::Options::accuracies, &Trade::Options::overlaps}) {
    if ((options.*list).empty()) options.*list = preset.*list;
  }
  options.time_limit = flags.time_limit.value_or(preset.time_limit);
  options.negligible = flags.negligible.value_or(preset.negligible);
  options.replicas = flags.replicas.value_or(preset.replicas);
  options.shorten = preset.shorten;
  if (!flags.quiet) options.warn = &warn_once;
  return options;
}

int run_trade(const TradeFlags& flags) {
  flags.prepare(true);
  std::string of_scene = typed_command(flags.options.targets);
  if (flags.options.targets.empty()) of_scene.insert(std::string("bipot trade").size(), " {}");
  const FinishedTrade finished = watched(flags.silent(), [&](const Watch& watch) {
    Trade::Options options = options_of(flags);
    options.watch = watch;
    return finished_trade(options, typed_command(), of_scene);
  });
  if (!flags.out.empty()) write_trade(flags.out, finished);
  flags.deliver(to_json(finished), to_text(trade_document(finished)), "results in " + flags.out);
  return finished.trade.complete ? kExitConverged : kExitInterrupted;
}

}  // namespace

ProgramCommand trade_command(CommandLine& line) {
  return make_command(line, &add_trade, &run_trade);
}

}  // namespace bipot
