#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bipot {

struct Chart {
  /// A chart, drawn by gnuplot (bench/report/program.h) as SVG with its text as text.
  struct Point {
    double x = 0, y = 0;
    bool hollow = false;  ///< drawn without filling
    /// Shown by the browser when the pointer rests on the marker; empty: its numbers.
    std::string note;
    bool marked = true;
    /// Ends of an error bar; none if one is not finite.
    double y_low = std::numeric_limits<double>::quiet_NaN();
    double y_high = std::numeric_limits<double>::quiet_NaN();
  };
  struct Series {
    enum class Kind {
      kLinePoints,  ///< markers, joined in the order of the points
      kLine,        ///< no markers: a fit, a theory
      kPoints,      ///< markers that nothing joins
      kSteps        ///< y holds from x to the next x; markers on request
    };
    std::string name;  ///< in the key; empty: not there
    /// Colour, marker and dashes. No two up to 29 share both marker and dashes, so that grey
    /// suffices.
    int style = 0;
    std::vector<Point> points;
    Kind kind = Kind::kLinePoints;
    bool background = false;  ///< wide and grey behind the others, without markers; kLine or kSteps
  };
  struct Axis {
    enum class Kind { kLinear, kLog, kLogSeconds };
    std::string label;
    Kind kind = Kind::kLinear;
    std::optional<double> low, high;  ///< else from the data
  };
  /// A reference, drawn across the chart.
  struct Line {
    double at = 0;
    std::string label;
  };
  enum class Key { kBelow, kRight, kNone };
  std::string title;  ///< for readers who do not see the drawing; drawn in files alone
  Axis x, y;
  std::vector<Series> series;
  std::vector<Line> x_lines, y_lines;  ///< vertical and horizontal lines
  Key key = Key::kBelow;
  /// Size of the axes with their labels; the key is additional. In units in which text is 12 high.
  double width = 440, height = 300;
};

/// An SVG element for a page, without scripts or external resources. Points that are not finite are
/// left out. Logarithmic axes show non-positive values, and values below a lower limit, at their
/// lowest value. A chart without points is an empty frame with a text. Ids depend on the content,
/// so that several charts can be in one page. Throws FileError as run_gnuplot does.
std::string to_svg(const Chart& chart);
/// Many at once, by one run of gnuplot; equal charts get different ids.
std::vector<std::string> to_svg(std::span<const Chart> charts);

/// Writes into an existing folder: name.csv, a line for each point with series, x, y and note; and
/// name.gp, from which `gnuplot name.gp` makes name.svg. Needs no gnuplot. Throws FileError.
void write_chart_data(const std::filesystem::path& folder, const std::string& name,
                      const Chart& chart);
/// The same, and then name.svg. Throws FileError.
void write_chart_files(const std::filesystem::path& folder, const std::string& name,
                       const Chart& chart);

/// Throws FileError if gnuplot is missing or older than 5.4: for a check before hours of
/// computation.
void require_plotting_tool();

}  // namespace bipot
