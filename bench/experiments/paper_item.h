#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "bench/report/chart.h"

namespace bipot {

/// What a figure or table of the paper has to work with.
struct PaperContext {
  std::filesystem::path out;                    ///< of the report; exists
  bool quick = false;                           ///< small sizes, seconds
  std::function<void(const std::string&)> say;  ///< progress, one line; may be empty
  std::function<bool()> interrupted;            ///< asked between pieces of work; may be empty

  void report(const std::string& what) const {
    if (say) say(what);
  }
  bool stopped() const { return interrupted && interrupted(); }
};

/// A number that the page states. Whatever the prose says is one of these.
struct PaperNumber {
  std::string name;  ///< unique in its item: "base_load_over_weight"
  double value = std::numeric_limits<double>::quiet_NaN();
  std::string unit;           ///< empty: dimensionless
  std::string meaning;        ///< one line
  std::string expected;       ///< by theory or the paper, with its source; empty: nothing is known
  std::optional<bool> holds;  ///< of a check against `expected`
  std::string command;        ///< that makes it again; empty: the item's own
  int digits = 4;             ///< significant, as the page writes it
};

/// A drawing: a chart, or a file of `out` (SVG).
struct PaperFigure {
  /// Of the files <name>.svg and, for charts, <name>.csv and <name>.gp; begins with the item's.
  std::string name;
  std::string caption;
  std::string command;  ///< empty: the item's own
  std::optional<Chart> chart;
  std::string file;          ///< relative to `out`; without chart
  bool wide = false;         ///< two columns of the page
  std::optional<int> after;  ///< stands behind this paragraph of `ours`, from 0; else behind all
};

struct PaperTable {
  std::string name, caption, command;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
};

/// One item, done.
struct PaperResult {
  std::string paper;  ///< what the paper reports, a sentence or two of our own
  /// What we get, paragraphs; "{name}" stands for a number, filled in with its unit; `code` in
  /// backticks.
  std::vector<std::string> ours;
  std::vector<PaperNumber> numbers;
  std::vector<PaperFigure> figures;
  std::vector<PaperTable> tables;
};

/// A row of the table of items. An item that was asked to stop (context.interrupted) returns early;
/// what it returns is not shown. One that cannot do its work throws, and the page shows the
/// message.
struct PaperItem {
  std::string_view name;   ///< for --only
  std::string_view title;  ///< "Fig. 10: quasi-static arrays"
  PaperResult (*run)(const PaperContext&);
};

/// In the order of the page. Adding one: a source paper_<name>.cc, its declaration in
/// paper_items.h, a row in paper_items.cc, a line in CMakeLists.txt.
const std::vector<PaperItem>& paper_items();

}  // namespace bipot
