#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "core/base/types.h"

namespace bipot {

/// Expected value of an observable: one value, or an interval with one or two ends. Errors are in
/// units of `scale`.
struct Expectation {
  double low = -kInfinity, high = kInfinity;
  double scale = 1;  ///< > 0

  static Expectation equal(double value) {
    return {value, value, value == 0 ? 1 : std::abs(value)};
  }
  static Expectation at_least(double low) { return at_least(low, equal(low).scale); }
  static Expectation at_most(double high) { return at_most(high, equal(high).scale); }
  static Expectation at_least(double low, double scale) { return {low, kInfinity, scale}; }
  static Expectation at_most(double high, double scale) { return {-kInfinity, high, scale}; }
  static Expectation between(double low, double high, double scale) { return {low, high, scale}; }

  /// Distance of a value from the interval, relative to the scale: 0 inside, NaN for NaN.
  double error(double value) const;
};

/// An error bar that is wider than this fraction of the scale decides nothing.
constexpr double kWidestBar = 0.5;

/// Verdict on a value that lies `off` outside of what is expected. `bar`: half width of its 95 %
/// error bar, in the unit of `off`. Within one bar it holds. Beyond two, where chance does not lead,
/// it is refuted. Between them, or with a bar wider than `widest`, it is undecided: none.
std::optional<bool> decide(double off, double bar, double widest);

/// Expected value of a quantity, its source, and the measured value. A row of `bipot paper` and of
/// `bipot validate`.
struct Claim {
  std::string name;  ///< unique in its findings: "base_load_over_weight"
  double measured = kNaN;
  std::string unit;           ///< empty: dimensionless, or said by `quantity`
  std::string quantity;       ///< one line
  std::string expected;       ///< in words and figures; empty: nothing is known
  std::optional<bool> holds;  ///< none: not checked, or `reason` explains why it is undecided
  std::string command;        ///< makes it again; empty: that of the findings
  int digits = 4;             ///< significant, as the page writes it
  std::string source;         ///< citation or argument; empty: `expected` says it
  double bar = 0;             ///< half width of the error bar, 0: none
  std::string bar_is;         ///< meaning of the error bar: samples, or discretisation
  std::string reason;         ///< why it does not hold or is undecided
  std::string note;           ///< a remark on the measurement
};

/// Findings of one item. In texts, "{name}" stands for a claim's value with its unit.
struct Findings {
  /// A drawing: a chart, or an SVG file of the folder.
  struct Figure {
    std::string name;  ///< of the files <name>.svg and, for charts, <name>.csv and <name>.gp
    std::string caption;
    std::string command;  ///< empty: that of the findings
    std::optional<Chart> chart;
    std::string file;          ///< relative to the folder; without chart
    bool wide = false;         ///< two columns of the page
    std::optional<int> after;  ///< follows this paragraph of `ours`, from 0; else follows all
  };
  struct Table {
    std::string name, caption, command;
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows;
  };
  std::string paper;              ///< the paper's report in one or two sentences
  std::vector<std::string> ours;  ///< paragraphs
  std::vector<Claim> claims;
  std::vector<Figure> figures;
  std::vector<Table> tables;

  /// Adds a number that texts quote.
  Claim& state(std::string name, double measured, std::string unit, std::string quantity,
               int digits = 4);
  /// Adds a number with an expected value; without `holds` both are shown side by side.
  Claim& check(std::string name, double measured, std::string unit, std::string quantity,
               std::string expected, std::optional<bool> holds, int digits = 4);
  /// The same with an error bar, see decide().
  Claim& test(std::string name, double measured, std::string unit, std::string quantity,
              std::string expected, const Expectation& range, double bar, std::string bar_is,
              int digits = 4);
  /// Adds a chart after the paragraph `after`.
  void draw(std::string name, std::string caption, Chart chart, std::optional<int> after = {});
  /// Adds the picture <name>.svg of the folder.
  void show(std::string name, std::string caption, std::optional<int> after = {});
};

/// Replaces "{name}" by the claims' values; gives `command` to all without one, and says of checks
/// without a bar that their limit is the discretisation. Throws
/// std::invalid_argument for a placeholder that names no claim, two claims of one name, or a figure
/// with neither or both of chart and file.
void complete(Findings& findings, const std::string& command);

/// For reading: `digits` significant ones, integers whole with groups of three, "undefined" for
/// NaN, 1.5e-9, unit after a no-break space.
std::string to_text(double value, const std::string& unit, int digits);
/// The measured value, with its error bar if it has one.
std::string measured_text(const Claim& claim);

}  // namespace bipot
