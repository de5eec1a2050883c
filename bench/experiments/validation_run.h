#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "bench/experiments/validation_row.h"

namespace bipot {

/// Error up to which an observable counts as right, beside its bar: what "the physics holds" means
/// where a row asks "at which tolerance?".
inline constexpr double kRightTo = 1e-2;

/// An error bar that is wider than this share of a row's scale decides nothing.
inline constexpr double kWidestBar = 0.5;

/// Share of the steps that may miss the tolerance in a run that counts as one at that tolerance.
inline constexpr double kMayMiss = 0.01;

/// A row at one tolerance.
struct ValidationPoint {
  double tol = 0;
  Observation seen;
  double error = kNaN;  ///< of the value, see Expectation::error
  bool right = false;   ///< at most kRightTo (or what is allowed, if that is more) and the bar
  long steps = 0, unsolved = 0;
  double seconds = 0;   ///< CPU, of the experiment: with the other rows that it measures
  std::string failure;  ///< why there is no value

  /// The steps were solved to the tolerance, all but kMayMiss of them, and there is a value.
  bool reached() const {
    return failure.empty() &&
           static_cast<double>(unsolved) <= kMayMiss * static_cast<double>(steps) &&
           std::isfinite(seen.value);
  }
};

/// A row at all its tolerances, and what comes of it.
struct ValidationVerdict {
  ValidationRow row;
  std::vector<ValidationPoint> points;  ///< tolerances falling
  int best = -1;                        ///< the tightest tolerance that was reached; -1: none was
  bool holds = false;                   ///< there: the error is at most row.allowed and the bar
  bool undecided = false;               ///< there: the bar is too wide to say; does not hold either
  std::string reason;                   ///< where it does not hold
  double loosest = kNaN;  ///< right here and at all tighter tolerances that were reached
  double seconds = 0;     ///< CPU, of all tolerances, of the experiment
  int shared = 1;         ///< rows that the experiment measures

  const ValidationPoint* measured() const { return best < 0 ? nullptr : &points[to_size(best)]; }
};

/// From the points; sets best, holds, reason and loosest.
void judge(ValidationVerdict& verdict);

struct ExperimentResult {
  std::vector<ValidationVerdict> verdicts;  ///< one for each row
  std::vector<ValidationFigure> figures;    ///< of the tightest tolerance that gave some
  bool complete = true;                     ///< false: the context stopped it
};

/// The experiment at each of its tolerances. What it throws at one of them stands in the points.
/// `on_tolerance`: before each, how many are done and how many there are.
ExperimentResult run_experiment(const ValidationExperiment& experiment,
                                const ValidationContext& context,
                                const std::function<void(int done, int total)>& on_tolerance = {});

struct ValidationPage {
  std::string command, solver;
  bool quick = false, complete = true;
  std::vector<ValidationVerdict> verdicts;
  std::vector<ValidationFigure> figures;

  int held() const;
  int undecided() const;
  int failed() const;  ///< neither
};

}  // namespace bipot
