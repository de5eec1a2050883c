#include "bench/tradeoff/trade_charts.h"

#include <fmt/format.h>

#include "bench/measure/statistics.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

Chart ratio_chart(const SceneTrade& s) {
  Chart ratio{.title = "Solver error over the others, " + s.scene->name,
              .x = {"tolerance", Chart::Axis::Kind::kLog},
              .y = {"solver's error / other errors", Chart::Axis::Kind::kLog, 1e-4},
              .y_lines = {{1, "as large as the others"}}};
  bool any = false;  // else there is nothing to see
  for (std::size_t q = 0; q < s.quantities.size(); ++q) {
    const SceneTrade::Errors& e = s.quantities[q];
    const double other = e.bound();
    if (!(other > 0)) continue;
    Chart::Series series{s.scene->quantities[q].name, static_cast<int>(q), {}};
    // The tightest is the reference of the others.
    for (std::size_t k = 0; k + 1 < s.tols.size(); ++k) {
      series.points.push_back({s.tols[k], e.solver_error[k] / other, false,
                               fmt::format("{} at {}: solver {:.1e}, others {:.1e}", series.name,
                                           tolerance_label(s.tols[k]), e.solver_error[k], other)});
    }
    any |= std::ranges::any_of(e.solver_error, [](double x) { return x > 0; });
    ratio.series.push_back(std::move(series));
  }
  if (!any) ratio.series.clear();
  return ratio;
}

/// Settings that one line of a chart joins.
struct Family {
  std::string name;
  int style;
  std::function<bool(const RunSetting&)> has;
};

std::vector<Family> families_of(const SceneTrade& s) {
  std::vector<Family> families;
  for (const std::string& name : distinct_in_order(
           s.cells, [](const SceneTrade::Cell& cell) { return cell.setting.solver; })) {
    if (name.empty()) continue;  // springs
    families.push_back(
        {name + ", tolerances", static_cast<int>(families.size()), [name](const RunSetting& x) {
           return x.equal_steps() && x.solver == name && x.step_factor == 1;
         }});
  }
  families.push_back(
      {s.solver + ", time steps", static_cast<int>(families.size()), [&s](const RunSetting& x) {
         return x.equal_steps() && x.solver == s.solver && x.tol == s.step_tol;
       }});
  families.push_back({s.solver + ", accuracies", static_cast<int>(families.size()),
                      [](const RunSetting& x) { return x.cut(); }});
  families.push_back({"springs, stiffness", static_cast<int>(families.size()),
                      [](const RunSetting& x) { return x.dem(); }});
  return families;
}

/// Error of the outcome, and penetration, against cost.
std::pair<Chart, Chart> cost_charts(const SceneTrade& s) {
  Chart error{.title = "Error of the outcome against cost, " + s.scene->name,
              .x = {"CPU time per simulated second", Chart::Axis::Kind::kLogSeconds},
              .y = {"worst error of an outcome", Chart::Axis::Kind::kLog}};
  Chart depth{.title = "Penetration against cost, " + s.scene->name,
              .x = error.x,
              .y = {"largest overlap / smaller radius", Chart::Axis::Kind::kLog}};
  double noise = 0;
  for (const SceneTrade::Errors& e : s.quantities) noise = std::max(noise, e.noise);
  for (const Family& family : families_of(s)) {
    Chart::Series in_error{family.name, family.style, {}}, in_depth = in_error;
    std::vector<const SceneTrade::Cell*> cells;
    for (const SceneTrade::Cell& cell : s.cells) {
      if (family.has(cell.setting) && cell.done()) cells.push_back(&cell);
    }
    // Along the family's own parameter, not in the order of the runs.
    std::ranges::stable_sort(cells, std::greater<>(), [](const SceneTrade::Cell* cell) {
      return std::pair(cell->setting.accuracy, cell->setting.step_factor);
    });
    for (const SceneTrade::Cell* cell : cells) {
      std::size_t q = 0;
      const double worst = s.worst_error(*cell, &q);
      const std::string note = fmt::format("{}: {} per simulated second", cell->setting.label(),
                                           seconds_label(cell->cpu_per_second));
      if (worst >= 0) {
        in_error.points.push_back(
            {cell->cpu_per_second, worst, false,
             note + fmt::format(", {} {:.1e}", s.scene->quantities[q].name, worst)});
      }
      if (cell->penetration >= 0) {
        in_depth.points.push_back({cell->cpu_per_second, cell->penetration, false,
                                   note + fmt::format(", overlap {:.1e}", cell->penetration)});
      }
    }
    if (!in_error.points.empty()) error.series.push_back(std::move(in_error));
    if (!in_depth.points.empty()) depth.series.push_back(std::move(in_depth));
  }
  if (noise > 0) error.y_lines = {{noise, "nearby runs"}};
  return {std::move(error), std::move(depth)};
}

}  // namespace

std::vector<Figure> trade_charts(const SceneTrade& scene) {
  auto [error, depth] = cost_charts(scene);
  std::vector<Figure> charts;
  charts.push_back({.chart = ratio_chart(scene),
                    .caption = "Below the line the solver is better than the outcome needs."});
  charts.push_back({.chart = std::move(error),
                    .caption = "What cost buys: the outcome that is furthest from the reference. "
                               "An error of 0, as the reference has, stands on the axis."});
  charts.push_back({.chart = std::move(depth),
                    .caption = "How deep bodies enter each other, and what that costs."});
  std::erase_if(charts, [](const Figure& f) {
    return std::ranges::all_of(f.chart->series,
                               [](const Chart::Series& series) { return series.points.empty(); });
  });
  return charts;
}

}  // namespace bipot
