#include "bench/compare/comparison_charts.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/report/labels.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

/// A solver keeps its marker in all figures of all reports of a build.
int style_of(const std::string& solver) {
  const auto names = solver_names();
  return static_cast<int>(std::ranges::find(names, solver) - names.begin());
}

/// The steps of a distribution: each of the sorted values raises the curve by 1/total. Starts at
/// `begin`, ends at `end`; markers are thinned out.
Chart::Series distribution(const std::string& name, int style, const std::vector<double>& values,
                           std::size_t total, double begin, double end) {
  Chart::Series series{name, style, {}, Chart::Series::Kind::kSteps};
  if (values.empty() || total == 0) return series;
  const std::size_t stride = 1 + values.size() / 5;
  series.points.push_back({begin, 0, false, "", false});
  for (std::size_t i = 0; i < values.size() && values[i] <= end; ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(total);
    const bool marked = (values.size() - 1 - i) % stride == 0;
    series.points.push_back({values[i], share, false,
                             fmt::format("{}: {:.0f} % up to {:.3g}", name, 100 * share, values[i]),
                             marked});
  }
  series.points.push_back({end, series.points.back().y, false, "", false});
  return series;
}

double decade_above(double x) { return std::pow(10, std::ceil(std::log10(x) - 1e-9)); }
double decade_below(double x) { return std::pow(10, std::floor(std::log10(x) + 1e-9)); }

Chart::Axis error_axis(const Comparison& comparison, const Comparison::Problem& problem,
                       const Ranking& rank) {
  double least = 1;
  for (const Comparison::Row& r : comparison.rows) {
    if (r.problem == problem.name && rank.of(r) > 0) least = std::min(least, rank.of(r));
  }
  Chart::Axis axis{std::string(rank.name()), Chart::Axis::Kind::kLog};
  if (rank.measure == Ranking::Measure::kForce) axis.label = "force error, worst body";
  // An error of exactly 0 needs a place on the axis.
  axis.low = std::max(1e-15, decade_below(least));
  return axis;
}

/// Error against time or tolerance: the same rows.
Chart error_chart(const Comparison& comparison, const Comparison::Problem& problem,
                  double (*x)(const Comparison::Row&)) {
  const Ranking rank = ranking(problem, comparison.rows);
  Chart chart{.y = error_axis(comparison, problem, rank)};
  if (rank.measure != Ranking::Measure::kGuarded &&
      problem.reference.error.guarded() >= *chart.y.low) {
    chart.y_lines = {{problem.reference.error.guarded(), "guarded error of the reference"}};
  }
  for (const std::string& solver : solvers_of(comparison)) {
    Chart::Series series{solver, style_of(solver), {}};
    for (const Comparison::Row& r : comparison.rows) {
      if (r.problem != problem.name || r.solver != solver) continue;
      const double error = rank.of(r);
      if (!std::isfinite(error) || !std::isfinite(r.time())) continue;
      series.points.push_back(
          {x(r), error, !r.solved(),
           fmt::format("{} at {}: {}, {} iterations, {}, {} {}", solver, tolerance_label(r.tol),
                       r.status, r.iterations, seconds_label(r.time()), rank.name(),
                       error_label(error))});
    }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

Chart profile_chart(const std::vector<PerformanceProfile>& profiles, const std::string& cost,
                    const std::string& title) {
  double largest = 10;
  for (const PerformanceProfile& p : profiles) {
    if (!p.ratios.empty()) largest = std::max(largest, p.ratios.back());
  }
  // Beyond a thousand times the best, differences are not shown.
  Chart chart{.title = title,
              .x = {cost + " over the least of all solvers", Chart::Axis::Kind::kLog, 1.0,
                    std::min(1e3, decade_above(largest))},
              .y = {"share of problems solved", Chart::Axis::Kind::kLinear, 0.0, 1.0}};
  for (const PerformanceProfile& p : profiles) {
    chart.series.push_back(distribution(p.solver, style_of(p.solver), p.ratios,
                                        static_cast<std::size_t>(p.problems), 1.0, *chart.x.high));
  }
  return chart;
}

Chart budget_chart(const std::vector<BudgetErrors>& errors, const std::string& title) {
  constexpr double kLeast = 1e-12;
  Chart chart{.title = title,
              .x = {"true error reached", Chart::Axis::Kind::kLog, kLeast, 1.0},
              .y = {"share of problems", Chart::Axis::Kind::kLinear, 0.0, 1.0}};
  for (const BudgetErrors& e : errors) {
    std::vector<double> reached;  // an error of 1 is no result
    for (double error : e.errors) {
      if (error < 1) reached.push_back(std::max(error, kLeast));
    }
    chart.series.push_back(
        distribution(e.solver, style_of(e.solver), reached, e.errors.size(), kLeast, 1.0));
  }
  return chart;
}

Chart regret_chart(const std::vector<Regret>& regrets, const std::vector<std::string>& names) {
  double least = 1, largest = 10;
  std::vector<std::vector<double>> ratios;
  for (const Regret& regret : regrets) {
    auto& finite = ratios.emplace_back();
    for (const Regret::Entry& entry : regret.entries) {
      if (!std::isfinite(entry.ratio)) continue;
      finite.push_back(entry.ratio);
      least = std::min(least, entry.ratio);
      largest = std::max(largest, entry.ratio);
    }
    std::ranges::sort(finite);
  }
  Chart chart{.title = "Time of auto over that of the fastest other solver",
              .x = {"time over the fastest other solver's", Chart::Axis::Kind::kLog,
                    decade_below(least), decade_above(largest)},
              .y = {"share of cases", Chart::Axis::Kind::kLinear, 0.0, 1.0},
              .x_lines = {{1, "as fast"}}};
  for (std::size_t i = 0; i < regrets.size(); ++i) {
    chart.series.push_back(distribution(names[i], static_cast<int>(i), ratios[i],
                                        regrets[i].entries.size(), *chart.x.low, *chart.x.high));
  }
  return chart;
}

Chart success_chart(const std::vector<SuccessCurve>& curves, std::string_view size) {
  Chart chart{.title = fmt::format("Success against tolerance, {}", size),
              .x = {"tolerance", Chart::Axis::Kind::kLog},
              .y = {"share of problems solved", Chart::Axis::Kind::kLinear, 0.0, 1.0}};
  for (const SuccessCurve& curve : curves) {
    if (curve.size != size) continue;
    Chart::Series series{curve.solver, style_of(curve.solver), {}};
    for (const SuccessCurve::Point& point : curve.points) {
      series.points.push_back(
          {point.tol, curve.share(point), false,
           fmt::format("{} to {}: {} of {}", curve.solver, tolerance_label(point.tol), point.solved,
                       curve.problems)});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart work_precision_chart(const Comparison& comparison, const Comparison::Problem& problem) {
  Chart chart = error_chart(comparison, problem, [](const Comparison::Row& r) { return r.time(); });
  chart.title = "Work and precision, " + problem.name;
  chart.x = {"time", Chart::Axis::Kind::kLogSeconds};
  const Ranking rank = ranking(problem, comparison.rows);
  auto best = pareto_rows(problem, comparison.rows);
  if (best.size() < 2) return chart;
  std::ranges::sort(best, {}, &Comparison::Row::time);
  Chart::Series front{"beaten by none", 0, {}, Chart::Series::Kind::kSteps, true};
  for (const Comparison::Row* row : best) front.points.push_back({row->time(), rank.of(*row)});
  chart.series.push_back(std::move(front));
  return chart;
}

Chart tolerance_chart(const Comparison& comparison, const Comparison::Problem& problem) {
  Chart chart = error_chart(comparison, problem, [](const Comparison::Row& r) { return r.tol; });
  chart.title = "Error against tolerance, " + problem.name;
  chart.x = {"tolerance", Chart::Axis::Kind::kLog};
  return chart;
}

Chart history_chart(const Comparison& comparison, const Comparison::Problem& problem) {
  constexpr double kMost = 100;  // diverging values leave the picture
  Chart chart{.title = "Guarded error against iteration, " + problem.name,
              .x = {"iteration", Chart::Axis::Kind::kLog, 1.0, {}},
              .y = {"guarded error", Chart::Axis::Kind::kLog}};
  double largest = 0, least = 1;
  for (const Comparison::History& history : comparison.histories) {
    if (history.problem != problem.name || history.points.empty()) continue;
    Chart::Series series{history.solver, style_of(history.solver), {}};
    int next = 1;  // a marker for each quadrupling
    for (std::size_t i = 0; i < history.points.size(); ++i) {
      const Comparison::History::Point& p = history.points[i];
      const bool last = i + 1 == history.points.size();
      const bool marked = last || p.iteration >= next;
      if (p.iteration >= next) next = 4 * std::max(1, p.iteration);
      series.points.push_back(
          {static_cast<double>(p.iteration), p.guarded(), false,
           marked ? fmt::format("{}: iteration {}, {}, guarded error {}", history.solver,
                                p.iteration, seconds_label(p.seconds), error_label(p.guarded()))
                  : "",
           marked});
      if (std::isfinite(p.guarded())) largest = std::max(largest, p.guarded());
      if (p.guarded() > 0) least = std::min(least, p.guarded());
    }
    chart.series.push_back(std::move(series));
  }
  chart.y.low = std::max(1e-15, decade_below(least));
  if (largest > kMost) chart.y.high = kMost;
  return chart;
}

Chart growth_chart(const std::vector<Growth>& all, const std::string& series, double tol,
                   Growth::Measure quantity) {
  const bool time = quantity == Growth::Measure::kTime;
  Chart chart{.title = fmt::format("{} against size, {} at {}", time ? "Time" : "Iterations",
                                   series, tolerance_label(tol)),
              .x = {"degrees of freedom", Chart::Axis::Kind::kLog},
              .y = {time ? "time" : "iterations",
                    time ? Chart::Axis::Kind::kLogSeconds : Chart::Axis::Kind::kLog}};
  for (const Growth& g : all) {
    if (g.series != series || g.tol != tol) continue;
    const PowerLaw& law = time ? g.time : g.iterations;
    Chart::Series points{g.solver, style_of(g.solver), {}, Chart::Series::Kind::kPoints};
    double from = kInfinity, to = 0;
    for (const Growth::Point& p : g.points) {
      if (!std::isfinite(p.time)) continue;
      points.points.push_back(
          {p.dofs, time ? p.time : p.iterations, !p.solved,
           fmt::format("{} on {}: {}{} iterations, {}", g.solver, p.problem,
                       p.solved ? "" : "not solved, ", p.iterations, seconds_label(p.time))});
      if (!p.solved) continue;
      from = std::min(from, p.dofs);
      to = std::max(to, p.dofs);
    }
    if (points.points.empty()) continue;
    chart.series.push_back(std::move(points));
    if (!(law.points >= 2 && std::isfinite(law.exponent))) continue;
    Chart::Series fit{"", style_of(g.solver), {}, Chart::Series::Kind::kLine};
    for (double n : {from, to}) {
      fit.points.push_back({n, law.prefactor * std::pow(n, law.exponent)});
    }
    chart.series.push_back(std::move(fit));
  }
  return chart;
}

}  // namespace bipot
