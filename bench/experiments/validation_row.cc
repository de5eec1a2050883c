#include "bench/experiments/validation_row.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "bench/measure/stopwatch.h"
#include "bench/report/labels.h"

namespace bipot {

ValidationRow::ValidationRow(std::string name, std::string quantity, std::string source,
                             std::string formula, Expectation expected, Margin margin)
    : claim{.name = std::move(name),
            .quantity = std::move(quantity),
            .expected = std::move(formula),
            .source = std::move(source),
            .bar_is = std::move(margin.bar_is)},
      range(expected),
      allowed(margin.allowed),
      allowed_why(std::move(margin.why)) {}

SolverChoice Experiment::Trial::choice() const {
  return SolverChoice{.name = context.solver,
                      .tol = tol,
                      .max_iterations = context.max_iterations,
                      .parameters = {{"islands", "off"}}};
}

void Experiment::Trial::draw(std::string name, std::string caption, Chart chart) {
  figures.push_back(
      {.name = std::move(name), .caption = std::move(caption), .chart = std::move(chart)});
}

void Experiment::Trial::go_on() const {
  if (context.interrupted()) throw std::runtime_error("interrupted");
}

std::vector<double> decades(int first, int last) {
  std::vector<double> tols;
  for (int k = first; k <= last; ++k) tols.push_back(std::pow(10.0, -k));
  return tols;
}

std::vector<Experiment> made_by(std::initializer_list<void (*)(Experiment&)> makers) {
  std::vector<Experiment> all;
  for (const auto make : makers) make(all.emplace_back());
  return all;
}

std::vector<Experiment> validation_experiments() {
  std::vector<Experiment> all;
  const auto add = [&all](const char* group, const std::vector<Experiment>& experiments) {
    for (const Experiment& e : experiments) {
      all.push_back(e);
      for (ValidationRow& row : all.back().rows) row.group = group;
    }
  };
  add("exact cases: one body", slope_experiments());
  add("exact cases: what stands", standing_experiments());
  add("exact cases: bounces and swings", impact_experiments());
  add("exact cases: collisions", collision_experiments());
  add("exact cases: MFiX's DEM-01–05", mfix_experiments());
  add("exact cases: cohesion", cohesion_experiments());
  add("exact cases: a chain and its sweeps", chain_experiments());
  add("indeterminacy of forces", indeterminacy_experiments());
  add("packings", packing_experiments());
  add("distribution of forces", force_experiments());
  add("flow", flow_experiments());
  add("silo", silo_experiments());
  add("trends", trend_experiments());
  return all;
}

namespace {

// Fraction of the steps that may miss the tolerance in a run that counts at that tolerance.
constexpr double kMayMiss = 0.01;

std::string missed(const ValidationRow::Point& p) {
  return fmt::format("the solver did not reach it in {} of {} steps", p.unsolved, p.steps);
}

/// Reason for no value at any tolerance.
std::string no_value(const ValidationRow::Point& p) {
  const std::string why = !p.failure.empty() ? ": " + p.failure
                          : p.unsolved > 0
                              ? " " + missed(p)
                              : fmt::format(" the observable is undefined{}{}",
                                            p.seen.note.empty() ? "" : ": ", p.seen.note);
  return fmt::format("; at {}{}", tolerance_label(p.tol), why);
}

}  // namespace

bool ValidationRow::Point::reached() const {
  return failure.empty() &&
         static_cast<double>(unsolved) <= kMayMiss * static_cast<double>(steps) &&
         std::isfinite(seen.value);
}

void judge(ValidationRow& row) {
  const double scale = row.range.scale;
  Claim& claim = row.claim;
  row.best = -1;
  row.loosest = claim.measured = kNaN;
  claim.bar = 0;
  claim.holds = false;
  claim.reason.clear();
  for (ValidationRow::Point& p : row.points) {
    if (std::isnan(p.seen.bar)) p.seen.bar = kInfinity;
    p.error = row.range.error(p.seen.value);
    p.right = std::isfinite(p.error) && p.seen.bar <= kWidestBar * scale &&
              p.error <= std::max(kRightTo, row.allowed) + p.seen.bar / scale;
    if (p.reached()) row.best = static_cast<int>(&p - row.points.data());
  }
  if (row.best < 0) {
    claim.reason = "no value at any tolerance";
    if (!row.points.empty()) claim.reason += no_value(row.points.front());
    return;
  }
  const ValidationRow::Point& best = *row.measured();
  const double bar = best.seen.bar / scale;
  claim.measured = best.seen.value;
  claim.bar = best.seen.bar + row.allowed * scale;
  claim.holds = decide(std::max(0.0, best.error - row.allowed), bar, kWidestBar);
  const std::string off =
      fmt::format("off by {} of its scale at {}, {} are allowed", compact_label(best.error),
                  tolerance_label(best.tol), compact_label(row.allowed + bar));
  if (!claim.holds && bar > kWidestBar) {
    claim.reason = fmt::format("the error bar at {} is {} of its scale: too few samples to say",
                               tolerance_label(best.tol), compact_label(bar));
  } else if (!claim.holds) {
    claim.reason = fmt::format("{}, {} with a second error bar: too few samples to say", off,
                               compact_label(row.allowed + 2 * bar));
  } else if (!*claim.holds) {
    claim.reason = off;
    if (to_size(row.best) + 1 < row.points.size()) {
      const ValidationRow::Point& tighter = row.points[to_size(row.best) + 1];
      claim.reason += fmt::format(", and at {} {}", tolerance_label(tighter.tol),
                                  tighter.failure.empty() ? missed(tighter) : tighter.failure);
    }
  }
  for (int k = row.best; k >= 0; --k) {
    const ValidationRow::Point& p = row.points[to_size(k)];
    if (!p.reached()) continue;
    if (!p.right) break;
    row.loosest = p.tol;
  }
}

Experiment::Result run_experiment(const Experiment& experiment, const Experiment::Context& context,
                                  const std::function<void()>& on_tolerance) {
  Experiment::Result result{.rows = experiment.rows};
  for (ValidationRow& row : result.rows) row.shared = static_cast<int>(result.rows.size());
  for (const double tol : context.quick ? experiment.quick_tols : experiment.tols) {
    if (on_tolerance) on_tolerance();
    if (context.interrupted()) {
      result.complete = false;
      break;
    }
    const CpuStopwatch clock;
    Experiment::Trial trial{tol, context};
    std::string failure;
    try {
      experiment.run(trial);
      if (trial.seen.size() != experiment.rows.size()) {
        throw std::logic_error(
            fmt::format("{} observations for {} rows", trial.seen.size(), experiment.rows.size()));
      }
    } catch (const std::exception& e) {
      failure = e.what();
      trial.steps = trial.unsolved = 0;
      trial.seen.clear();
      trial.figures.clear();
    }
    if (context.interrupted()) {
      result.complete = false;
      break;
    }
    trial.seen.resize(experiment.rows.size());
    const double seconds = clock.seconds();
    for (std::size_t r = 0; r < result.rows.size(); ++r) {
      ValidationRow::Point point{.tol = tol,
                                 .seen = trial.seen[r],
                                 .steps = trial.steps,
                                 .unsolved = trial.unsolved,
                                 .seconds = seconds,
                                 .failure = failure};
      result.rows[r].points.push_back(std::move(point));
      result.rows[r].seconds += seconds;
    }
    if (!trial.figures.empty()) result.figures = std::move(trial.figures);
  }
  for (ValidationRow& row : result.rows) judge(row);
  return result;
}

}  // namespace bipot
