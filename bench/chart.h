#pragma once

#include <optional>
#include <string>
#include <vector>

namespace bipot {

/// A line chart as an SVG element, for pages that must stand alone. (Debian 12 packages no C++
/// library that writes plots as SVG; cairo draws, but knows no axes.)
struct ChartPoint {
  double x = 0, y = 0;
  bool hollow = false;  ///< drawn without filling
  std::string note;     ///< shown by the browser when the pointer rests on the marker
  bool marked = true;
};
struct ChartSeries {
  std::string name;
  int style = 0;  ///< marker, dashes and colour; differs in shape up to 16, so that grey suffices
  std::vector<ChartPoint> points;
};
struct ChartAxis {
  enum class Kind { kLinear, kLog, kLogSeconds };
  std::string label;
  Kind kind = Kind::kLinear;
  std::optional<double> low, high;  ///< else from the data
};
struct Chart {
  std::string title;  ///< for readers that do not see the drawing
  ChartAxis x, y;
  std::vector<ChartSeries> series;
  std::optional<double> y_line;  ///< a horizontal line
  std::string y_line_label;
};

/// Points that are not finite are left out; logarithmic axes lift what is not positive to their
/// lowest value.
std::string to_svg(const Chart& chart);

/// & < > " as entities.
std::string escape_markup(const std::string& text);

}  // namespace bipot
