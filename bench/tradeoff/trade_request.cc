#include "bench/tradeoff/trade_request.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "bench/report/labels.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

std::string numbers(const char* flag, const std::vector<double>& values) {
  if (values.empty()) return {};
  std::vector<std::string> words;
  for (const double x : values) words.push_back(tolerance_label(x));
  return fmt::format(" {} {}", flag, fmt::join(words, ","));
}

/// The command that makes this request, except output options.
std::string command_line(const std::string& scenes, const TradeRequest& request) {
  std::string line = "bipot trade";
  if (!scenes.empty()) line += " " + scenes;
  if (request.quick) line += " --quick";
  if (request.solvers != TradeRequest{}.solvers) {
    line += fmt::format(" --solvers {}", fmt::join(request.solvers, ","));
  }
  line += numbers("--tols", request.tols) + numbers("--step-sizes", request.step_sizes) +
          numbers("--accuracies", request.accuracies) + numbers("--overlaps", request.overlaps) +
          numbers("--stiffness", request.stiffness);
  if (request.time_limit) line += fmt::format(" --time-limit {:g}", *request.time_limit);
  if (request.negligible)
    line += fmt::format(" --negligible {}", tolerance_label(*request.negligible));
  if (request.witness != TradeRequest{}.witness) {
    line += fmt::format(" --witness {}", request.witness.empty() ? "none" : request.witness);
  }
  if (request.replicas) line += fmt::format(" --replicas {}", *request.replicas);
  return line;
}

Trade::Options options_of(const TradeRequest& request) {
  Trade::Options options;
  options.targets = request.scenes.empty() ? trade_targets(request.quick) : request.scenes;
  options.solvers = request.solvers;
  if (request.quick) {
    options.tols = {1e-1, 1e-3};
    options.step_factors = {2, 1, 0.5};
    options.accuracies = {0.1};
    options.overlaps = {1e-2, 1e-3};
    options.time_limit = 5;
    options.shorten = true;
    options.replicas = 2;
  }
  if (!request.tols.empty()) options.tols = request.tols;
  if (!request.step_sizes.empty()) options.step_factors = request.step_sizes;
  if (!request.accuracies.empty()) options.accuracies = request.accuracies;
  if (!request.overlaps.empty()) options.overlaps = request.overlaps;
  options.stiffness = request.stiffness;
  if (!request.overlaps.empty() && !request.stiffness.empty()) {
    throw std::invalid_argument("give --overlaps or --stiffness: one decides the other");
  }
  if (std::ranges::any_of(options.overlaps, [](double x) { return x >= 0.1; })) {
    throw std::invalid_argument("--overlaps: contacts that overlap by a tenth of the radius fail");
  }
  if (request.time_limit) options.time_limit = *request.time_limit;
  if (request.negligible) options.negligible = *request.negligible;
  if (request.replicas) options.replicas = *request.replicas;
  options.witness = request.witness;
  return options;
}

}  // namespace

FinishedTrade run_trade(const TradeRequest& request) {
  Trade::Options options = options_of(request);
  options.interrupted = request.interrupted;
  options.warn = request.warn;
  const std::size_t springs =
      options.stiffness.empty() ? options.overlaps.size() : options.stiffness.size();
  const std::size_t settings = options.solvers.size() * options.tols.size() +
                               options.step_factors.size() + options.accuracies.size() + springs +
                               (options.witness.empty() ? 0 : 1);
  const long total = static_cast<long>(settings * options.targets.size());
  long done = 0;
  if (request.progress) request.progress(done, total, "");
  options.on_row = [&](const Trade::Row& row) {
    if (row.replica == 0) ++done;
    if (!request.progress) return;
    request.progress(
        done, total,
        fmt::format("{}: {}, run {}", row.scene, row.setting.label(), row.replica + 1));
  };
  FinishedTrade finished(run_trade(options));
  finished.made =
      provenance("trade", command_line(fmt::format("{}", fmt::join(request.scenes, " ")), request));
  finished.command_of_scene = command_line("{}", request);
  finished.time_limit = options.time_limit;
  return finished;
}

void write_trade(const std::filesystem::path& folder, const FinishedTrade& finished) {
  write_text_file(folder / "trade.csv", to_csv(outcome_table(finished.trade)));
  write_json(to_json(finished), (folder / "trade.json").string());
  write_text_file(folder / "trade.html", to_html(trade_page(finished)));
}

}  // namespace bipot
