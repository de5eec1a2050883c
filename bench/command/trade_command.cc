#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "bench/command/commands.h"
#include "bench/command/exit_code.h"
#include "bench/command/watched_trade.h"
#include "bench/report/chart.h"
#include "bench/report/json_output.h"
#include "bench/tradeoff/trade_request.h"
#include "core/base/file_error.h"

namespace bipot {
namespace {

struct TradeFlags {
  TradeRequest request;
  bool quiet = false;
  std::string out, json;
};

CommandDeclaration add_trade(CommandLine& line, TradeFlags& flags) {
  CommandDeclaration command = line.add_command(
      "trade", "Whole simulations: what a tolerance, a time step and springs cost and buy");
  command.option("scenes", flags.request.scenes,
                 "Scene files or names of shipped scenes, each with :steps=N behind it for "
                 "another length (default: a set of them)");
  const auto list = [&](const char* name, auto& values, const char* type, const char* help) {
    return command.option(name, values, help).value_name(type);
  };
  list("--solvers", flags.request.solvers, "NAMES",
       "Solvers; the first one runs the time steps too")
      .show_default();
  list("--tols", flags.request.tols, "NUMBERS",
       "Tolerances (1e-1,1e-2,1e-3,1e-4,1e-6; quick 1e-1,1e-3)")
      .positive();
  list("--step-sizes", flags.request.step_sizes, "FACTORS",
       "Time steps over the scene's (2,1,0.5,0.25; quick 2,1,0.5)")
      .positive();
  list("--accuracies", flags.request.accuracies, "RADII",
       "Accuracies that cut steps of a frame, see run --accuracy (0.1,0.03; quick 0.1)")
      .positive();
  list("--overlaps", flags.request.overlaps, "FRACTIONS",
       "Springs by the overlap aimed at, of the smallest radius (1e-2,1e-3,1e-4; quick 1e-2,1e-3)")
      .positive();
  list("--stiffness", flags.request.stiffness, "N/m",
       "Springs by their stiffness, instead of --overlaps")
      .positive();
  command.option("--time-limit", flags.request.time_limit, "CPU seconds of one run (20; quick 5)")
      .value_name("SECONDS")
      .positive();
  command
      .option("--negligible", flags.request.negligible,
              "Relative error of an outcome that is good enough in any case (1e-4)")
      .not_negative();
  command
      .option("--replicas", flags.request.replicas,
              "Nearby runs of each setting where disks fly freely (3; quick 2)")
      .between(1, 1000);
  command
      .option(
          "--witness",
          [&flags](const std::string& name) {
            flags.request.witness = name == "none" ? std::string() : name;
          },
          "Solver that runs the tightest tolerance too, to see what several exact answers do "
          "(apgd; none)")
      .value_name("NAME");
  command.flag("--quick", flags.request.quick, "Fewer scenes and settings for a first look");
  command.option("--out", flags.out, "Folder for trade.csv, trade.json and trade.html")
      .value_name("DIR");
  command
      .option("--json", flags.json,
              "Write all of it as JSON; '-': standard output, with nothing else")
      .value_name("FILE");
  command.flag("--quiet,-q", flags.quiet, "No progress, no table on the terminal");
  command.footer(
      "Ends with 0 when everything was run: runs that fail or take too long are rows of it.\n"
      "Examples:\n"
      "  bipot trade --out out/trade\n"
      "  bipot trade my_scene.toml --tols 1e-1,1e-2,1e-3,1e-5 --time-limit 60 --out out/mine\n"
      "  bipot trade square_lattice:steps=300 --solvers auto,pgs --overlaps 1e-3,1e-5");
  return command;
}

int run_trade(const TradeFlags& flags) {
  const std::filesystem::path out = flags.out;
  if (!out.empty()) {
    require_plotting_tool();
    std::error_code error;
    std::filesystem::create_directories(out, error);
    if (error) throw FileError(out, "", "cannot create: " + error.message());
  }
  if (!flags.json.empty()) require_writable(flags.json);

  const bool quiet = flags.quiet || flags.json == "-";
  const FinishedTrade finished = run_watched_trade(flags.request, quiet);
  if (!out.empty()) write_trade(out, finished);
  if (!flags.json.empty()) write_json(to_json(finished.analysed, finished.context), flags.json);
  if (!quiet) {
    fmt::print("{}", to_text(trade_document(finished.analysed, finished.context)));
    if (!out.empty()) fmt::print("results in {}\n", flags.out);
  }
  return finished.analysed.trade.complete ? kExitConverged : kExitInterrupted;
}

}  // namespace

ProgramCommand trade_command(CommandLine& line) {
  return make_command(line, &add_trade, &run_trade);
}

}  // namespace bipot
