#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "core/base/types.h"
#include "core/scene/scene.h"

namespace bipot {

/// What an observable must be: one value, or an interval with one or two ends. Errors are measured
/// in units of `scale`.
struct Expectation {
  double low = -kInfinity, high = kInfinity;
  double scale = 1;  ///< > 0

  static Expectation equal(double value) {
    return {value, value, value == 0 ? 1 : std::abs(value)};
  }
  static Expectation at_least(double low, double scale) { return {low, kInfinity, scale}; }
  static Expectation at_most(double high, double scale) { return {-kInfinity, high, scale}; }
  static Expectation between(double low, double high, double scale) { return {low, high, scale}; }

  /// How far outside a value lies, relative to the scale: 0 inside, NaN for NaN.
  double error(double value) const;
};

/// An observable with what theory or others say of it.
struct ValidationRow {
  std::string name;      ///< for --only and the CSV: letters, digits, _
  std::string group;     ///< heading of the page
  std::string quantity;  ///< one line, with its unit or what it is relative to
  std::string source;    ///< citation, or the argument that gives the value
  std::string formula;   ///< the expected value in words and figures
  Expectation expected;
  /// Relative error that the row may have at the tightest tolerance beside its error bar, and why:
  /// time step, bisection.
  double allowed = 0;
  std::string allowed_why;
  std::string bar;              ///< what the error bar is
  bool takes_tolerance = true;  ///< false: nothing in it is solved to a tolerance
};

/// A row that takes a tolerance: the fields in their order.
ValidationRow validation_row(std::string group, std::string name, std::string quantity,
                             std::string source, std::string formula, Expectation expected,
                             double allowed, std::string allowed_why, std::string bar);

/// One measurement of an observable.
struct Observation {
  double value = kNaN;
  double bar = 0;  ///< half width of the error bar
  std::string note;
};

struct ValidationFigure {
  std::string name;  ///< of the files
  std::string group, caption;
  Chart chart;
};

/// One run of an experiment.
struct ExperimentOutcome {
  std::vector<Observation> seen;  ///< one for each row
  std::vector<ValidationFigure> figures;
  long steps = 0;     ///< time steps (or single problems) that were solved
  long unsolved = 0;  ///< of them, those whose solver did not reach the tolerance
};

struct ValidationContext {
  bool quick = false;             ///< fewer seeds, fewer bodies, fewer tolerances
  std::string solver = "apgd";    ///< of every step, without islands
  int max_iterations = 20000;     ///< a step
  std::function<bool()> stopped;  ///< asked between steps; may be empty

  bool interrupted() const { return stopped && stopped(); }
  SolverChoice choice(double tol) const;
};

/// Observables that one computation gives. Its work is done again for each tolerance.
struct ValidationExperiment {
  std::vector<ValidationRow> rows;
  std::vector<double> tols;        ///< falling
  std::vector<double> quick_tols;  ///< the same of --quick
  std::function<ExperimentOutcome(double tol, const ValidationContext&)> run;
};

/// All of them, in the order of the page.
std::vector<ValidationExperiment> validation_experiments();

/// 10^-first … 10^-last.
std::vector<double> decades(int first, int last);

}  // namespace bipot
