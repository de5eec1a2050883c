#include "bench/experiments/validation_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bench/measure/stopwatch.h"
#include "bench/report/labels.h"

namespace bipot {

void judge(ValidationVerdict& verdict) {
  const ValidationRow& row = verdict.row;
  verdict.best = -1;
  verdict.holds = verdict.undecided = false;
  verdict.reason.clear();
  verdict.loosest = kNaN;
  for (ValidationPoint& p : verdict.points) {
    p.error = row.expected.error(p.seen.value);
    p.right = std::isfinite(p.error) && p.seen.bar <= kWidestBar * row.expected.scale &&
              p.error <= std::max(kRightTo, row.allowed) + p.seen.bar / row.expected.scale;
    if (p.reached()) verdict.best = static_cast<int>(&p - verdict.points.data());
  }
  if (verdict.best < 0) {
    verdict.reason = "no value at any tolerance";
    for (const ValidationPoint& p : verdict.points) {
      if (!p.failure.empty()) {
        verdict.reason += fmt::format("; at {}: {}", tolerance_label(p.tol), p.failure);
        break;
      }
      if (p.unsolved > 0) {
        verdict.reason += fmt::format("; at {} the solver did not reach it in {} of {} steps",
                                      tolerance_label(p.tol), p.unsolved, p.steps);
        break;
      }
      verdict.reason +=
          fmt::format("; at {} the observable is undefined{}{}", tolerance_label(p.tol),
                      p.seen.note.empty() ? "" : ": ", p.seen.note);
      break;
    }
    return;
  }
  const ValidationPoint& best = verdict.points[to_size(verdict.best)];
  verdict.undecided = !(best.seen.bar <= kWidestBar * row.expected.scale);
  verdict.holds =
      !verdict.undecided && best.error <= row.allowed + best.seen.bar / row.expected.scale;
  if (verdict.undecided) {
    verdict.reason =
        fmt::format("the error bar at {} is {} of its scale: too few samples to say",
                    tolerance_label(best.tol), compact_label(best.seen.bar / row.expected.scale));
  } else if (!verdict.holds) {
    verdict.reason = fmt::format("off by {} of its scale at {}, {} are allowed",
                                 compact_label(best.error), tolerance_label(best.tol),
                                 compact_label(row.allowed + best.seen.bar / row.expected.scale));
    if (to_size(verdict.best) + 1 < verdict.points.size()) {
      const ValidationPoint& tighter = verdict.points[to_size(verdict.best) + 1];
      verdict.reason += fmt::format(
          ", and at {} {}", tolerance_label(tighter.tol),
          tighter.failure.empty() ? fmt::format("the solver did not reach it in {} of {} steps",
                                                tighter.unsolved, tighter.steps)
                                  : tighter.failure);
    }
  }
  for (int k = verdict.best; k >= 0; --k) {
    const ValidationPoint& p = verdict.points[to_size(k)];
    if (!p.reached()) continue;
    if (!p.right) break;
    verdict.loosest = p.tol;
  }
}

ExperimentResult run_experiment(const ValidationExperiment& experiment,
                                const ValidationContext& context,
                                const std::function<void(int, int)>& on_tolerance) {
  ExperimentResult result;
  for (const ValidationRow& row : experiment.rows) {
    result.verdicts.push_back({.row = row, .shared = static_cast<int>(experiment.rows.size())});
  }
  const std::vector<double>& tols = context.quick ? experiment.quick_tols : experiment.tols;
  for (std::size_t k = 0; k < tols.size(); ++k) {
    if (on_tolerance) on_tolerance(static_cast<int>(k), static_cast<int>(tols.size()));
    if (context.interrupted()) {
      result.complete = false;
      break;
    }
    const CpuStopwatch clock;
    ExperimentOutcome outcome;
    std::string failure;
    try {
      outcome = experiment.run(tols[k], context);
      if (context.interrupted()) {
        result.complete = false;
        break;
      }
      if (outcome.seen.size() != experiment.rows.size()) {
        throw std::logic_error(fmt::format("{} observations for {} rows", outcome.seen.size(),
                                           experiment.rows.size()));
      }
    } catch (const std::exception& e) {
      failure = e.what();
      outcome = {};
    }
    outcome.seen.resize(experiment.rows.size());
    const double seconds = clock.seconds();
    for (std::size_t r = 0; r < result.verdicts.size(); ++r) {
      ValidationPoint point;
      point.tol = tols[k];
      point.seen = outcome.seen[r];
      point.steps = outcome.steps;
      point.unsolved = outcome.unsolved;
      point.seconds = seconds;
      point.failure = failure;
      result.verdicts[r].points.push_back(std::move(point));
      result.verdicts[r].seconds += seconds;
    }
    if (!outcome.figures.empty()) result.figures = std::move(outcome.figures);
  }
  for (ValidationVerdict& verdict : result.verdicts) judge(verdict);
  return result;
}

int ValidationPage::held() const {
  return static_cast<int>(std::count_if(verdicts.begin(), verdicts.end(),
                                        [](const ValidationVerdict& v) { return v.holds; }));
}

int ValidationPage::undecided() const {
  return static_cast<int>(std::count_if(verdicts.begin(), verdicts.end(),
                                        [](const ValidationVerdict& v) { return v.undecided; }));
}

int ValidationPage::failed() const {
  return static_cast<int>(verdicts.size()) - held() - undecided();
}

}  // namespace bipot
