#include "bench/command/trade_command.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <stdexcept>

#include "bench/command/exit_code.h"
#include "bench/command/interrupt.h"
#include "bench/command/progress_bar.h"
#include "bench/report/chart.h"
#include "bench/report/json_output.h"
#include "bench/report/labels.h"
#include "bench/trade/trade_report.h"
#include "core/file_error.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

std::string numbers(const char* flag, const std::vector<double>& values) {
  if (values.empty()) return {};
  std::vector<std::string> words;
  for (const double x : values) words.push_back(tolerance_label(x));
  return fmt::format(" {} {}", flag, fmt::join(words, ","));
}

/// The command as it was typed, results aside.
std::string command_line(const std::string& scenes, const TradeFlags& flags) {
  std::string line = "bipot trade";
  if (!scenes.empty()) line += " " + scenes;
  if (flags.quick) line += " --quick";
  if (flags.solvers != TradeFlags{}.solvers) {
    line += fmt::format(" --solvers {}", fmt::join(flags.solvers, ","));
  }
  line += numbers("--tols", flags.tols) + numbers("--step-sizes", flags.step_sizes) +
          numbers("--overlaps", flags.overlaps) + numbers("--stiffness", flags.stiffness);
  if (flags.time_limit) line += fmt::format(" --time-limit {:g}", *flags.time_limit);
  if (flags.accuracy) line += fmt::format(" --accuracy {}", tolerance_label(*flags.accuracy));
  if (flags.replicas) line += fmt::format(" --replicas {}", *flags.replicas);
  return line;
}

}  // namespace

CLI::App* add_trade_command(CLI::App& app, TradeFlags& flags) {
  CLI::App* command = app.add_subcommand(
      "trade", "Whole simulations: what a tolerance, a time step and springs cost and buy");
  command->add_option("scenes", flags.scenes,
                      "Scene files or names of shipped scenes, each with :steps=N behind it for "
                      "another length (default: a set of them)");
  const auto list = [&](const char* name, auto& values, const char* type, const char* help) {
    return command->add_option(name, values, help)->delimiter(',')->type_name(type);
  };
  list("--solvers", flags.solvers, "NAMES", "Solvers; the first one runs the time steps too")
      ->capture_default_str();
  list("--tols", flags.tols, "NUMBERS", "Tolerances (1e-1,1e-2,1e-3,1e-4,1e-6; quick 1e-1,1e-3)")
      ->check(CLI::PositiveNumber);
  list("--step-sizes", flags.step_sizes, "FACTORS",
       "Time steps over the scene's (2,1,0.5,0.25; quick 2,1,0.5)")
      ->check(CLI::PositiveNumber);
  list("--overlaps", flags.overlaps, "FRACTIONS",
       "Springs by the overlap aimed at, of the smallest radius (1e-2,1e-3,1e-4; quick 1e-2,1e-3)")
      ->check(CLI::PositiveNumber);
  list("--stiffness", flags.stiffness, "N/m", "Springs by their stiffness, instead of --overlaps")
      ->check(CLI::PositiveNumber);
  command->add_option("--time-limit", flags.time_limit, "CPU seconds of one run (20; quick 5)")
      ->type_name("SECONDS")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--accuracy", flags.accuracy,
                   "Relative error of an outcome that is good enough in any case (1e-4)")
      ->check(CLI::NonNegativeNumber);
  command
      ->add_option("--replicas", flags.replicas,
                   "Nearby runs of each setting where disks fly freely (3; quick 2)")
      ->check(CLI::Range(1, 1000));
  command->add_flag("--quick", flags.quick, "Fewer scenes and settings for a first look");
  command->add_option("--out", flags.out, "Folder for trade.csv, trade.json and trade.html")
      ->type_name("DIR");
  command
      ->add_option("--json", flags.json,
                   "Write all of it as JSON; '-' is standard output, with nothing else on it")
      ->type_name("FILE");
  command->add_flag("--quiet,-q", flags.quiet, "No progress, no table on the terminal");
  command->footer(
      "Ends with 0 when everything was run: runs that fail or take too long are rows of it.\n"
      "Examples:\n"
      "  bipot trade --out out/trade\n"
      "  bipot trade my_scene.toml --tols 1e-1,1e-2,1e-3,1e-5 --time-limit 60 --out out/mine\n"
      "  bipot trade square_lattice:steps=300 --solvers auto,pgs --overlaps 1e-3,1e-5");
  return command;
}

FinishedTrade run_trade(const TradeFlags& flags, bool quiet) {
  TradeOptions options;
  options.targets = flags.scenes.empty() ? trade_targets(flags.quick) : flags.scenes;
  options.solvers = flags.solvers;
  if (flags.quick) {
    options.tols = {1e-1, 1e-3};
    options.step_factors = {2, 1, 0.5};
    options.overlaps = {1e-2, 1e-3};
    options.time_limit = 5;
    options.replicas = 2;
  }
  if (!flags.tols.empty()) options.tols = flags.tols;
  if (!flags.step_sizes.empty()) options.step_factors = flags.step_sizes;
  if (!flags.overlaps.empty()) options.overlaps = flags.overlaps;
  options.stiffness = flags.stiffness;
  if (!flags.overlaps.empty() && !flags.stiffness.empty()) {
    throw std::invalid_argument("give --overlaps or --stiffness: one decides the other");
  }
  if (std::any_of(options.overlaps.begin(), options.overlaps.end(),
                  [](double x) { return x >= 0.1; })) {
    throw std::invalid_argument("--overlaps: contacts that overlap by a tenth of the radius fail");
  }
  if (flags.time_limit) options.time_limit = *flags.time_limit;
  if (flags.accuracy) options.accuracy = *flags.accuracy;
  if (flags.replicas) options.replicas = *flags.replicas;
  const InterruptGuard interrupt;
  options.interrupted = &InterruptGuard::requested;
  // Replicas are not known yet: a bound, for the bar.
  const std::size_t springs =
      options.stiffness.empty() ? options.overlaps.size() : options.stiffness.size();
  const std::size_t settings =
      options.solvers.size() * options.tols.size() + options.step_factors.size() + springs;
  ProgressBar progress(static_cast<long>(settings * options.targets.size()), quiet);
  long done = 0;
  options.on_row = [&](const TradeRow& row) {
    if (row.replica == 0) ++done;
    progress.update(done,
                    fmt::format("{}: {}, run {}", row.scene, row.setting.label(), row.replica + 1));
  };
  Trade trade = run_trade(options);
  return {std::move(trade),
          {.command = command_line(fmt::format("{}", fmt::join(flags.scenes, " ")), flags),
           .command_of_scene = command_line("{}", flags),
           .time_limit = options.time_limit,
           .build = build_info(),
           .date = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)))}};
}

void write_trade(const fs::path& folder, const FinishedTrade& finished) {
  write_text_file(folder / "trade.csv", to_csv(finished.trade));
  write_json(to_json(finished.trade, finished.context), (folder / "trade.json").string());
  write_text_file(folder / "trade.html", trade_page(finished.trade, finished.context));
}

int trade_command(const TradeFlags& flags) {
  const fs::path out = flags.out;
  if (!out.empty()) {
    require_plotting_tool();
    std::error_code error;
    fs::create_directories(out, error);
    if (error) throw FileError(out, "", "cannot create: " + error.message());
  }
  if (!flags.json.empty()) require_writable(flags.json);

  const bool quiet = flags.quiet || flags.json == "-";
  const FinishedTrade finished = run_trade(flags, quiet);
  if (!out.empty()) write_trade(out, finished);
  if (!flags.json.empty()) write_json(to_json(finished.trade, finished.context), flags.json);
  if (!quiet) {
    fmt::print("{}", to_text(finished.trade));
    if (!out.empty()) fmt::print("results in {}\n", flags.out);
  }
  return finished.trade.complete ? kExitConverged : kExitInterrupted;
}

}  // namespace bipot
