#include "bench/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace bipot {
namespace {

constexpr double kWidth = 380, kHeight = 270;
constexpr double kLeft = 54, kRight = 20, kTop = 8, kBottom = 40;
constexpr int kLegendColumns = 4;
constexpr double kLegendRow = 15;

// Colours differ in lightness too; marker and dashes alone tell the series apart.
constexpr std::array<const char*, 8> kColours = {"#111111", "#0a66b0", "#c2410c", "#00805e",
                                                 "#a3337f", "#3f8fd0", "#7a5c00", "#6b3fc0"};
constexpr std::array<const char*, 5> kDashes = {"", "6 3", "2 2", "8 3 2 3", "10 4"};

struct Scale {
  bool log = false;
  double low = 0, high = 1, begin = 0, end = 1;

  double operator()(double v) const {
    if (log) v = std::log10(std::max(v, low));
    const double a = log ? std::log10(low) : low, b = log ? std::log10(high) : high;
    return begin + (end - begin) * (v - a) / (b - a);
  }
};

Scale make_scale(const ChartAxis& axis, std::vector<double> values, double begin, double end) {
  Scale scale;
  scale.log = axis.kind != ChartAxis::Kind::kLinear;
  scale.begin = begin;
  scale.end = end;
  std::erase_if(values, [&](double v) { return !std::isfinite(v) || (scale.log && v <= 0); });
  double low = scale.log ? 1e-3 : 0, high = 1;
  if (!values.empty()) {
    low = *std::min_element(values.begin(), values.end());
    high = *std::max_element(values.begin(), values.end());
  }
  if (axis.low) low = *axis.low;
  if (axis.high) high = *axis.high;
  if (scale.log) {
    if (!axis.low) low = std::pow(10, std::floor(std::log10(low) + 1e-9));
    if (!axis.high) high = std::pow(10, std::ceil(std::log10(high) - 1e-9));
    if (high < low * 9.99) high = low * 10;
  } else if (high <= low) {
    high = low + 1;
  }
  scale.low = low;
  scale.high = high;
  return scale;
}

std::string power_label(int exponent) {
  if (exponent == 0) return "1";
  if (exponent == 1) return "10";
  return fmt::format("10<tspan dy=\"-4\" font-size=\"8.5\">{}{}</tspan>", exponent < 0 ? "−" : "",
                     std::abs(exponent));
}

std::string seconds_label(int exponent) {
  if (exponent < -6) return fmt::format("{:g} ns", std::pow(10, exponent + 9));
  if (exponent < -3) return fmt::format("{:g} µs", std::pow(10, exponent + 6));
  if (exponent < 0) return fmt::format("{:g} ms", std::pow(10, exponent + 3));
  return fmt::format("{:g} s", std::pow(10, exponent));
}

struct Tick {
  double value;
  std::string label;
};

std::vector<Tick> ticks(const ChartAxis& axis, const Scale& scale) {
  std::vector<Tick> out;
  if (!scale.log) {
    for (int i = 0; i <= 4; ++i) {
      const double v = scale.low + (scale.high - scale.low) * i / 4;
      out.push_back({v, fmt::format("{:g}", v)});
    }
    return out;
  }
  const int first = static_cast<int>(std::ceil(std::log10(scale.low) - 1e-9));
  const int last = static_cast<int>(std::floor(std::log10(scale.high) + 1e-9));
  const int stride = std::max(1, (last - first + 6) / 7);
  for (int e = first; e <= last; ++e) {
    if ((e - last) % stride != 0) continue;
    out.push_back({std::pow(10, e),
                   axis.kind == ChartAxis::Kind::kLogSeconds ? seconds_label(e) : power_label(e)});
    if (last - first <= 1 && axis.kind == ChartAxis::Kind::kLog && e >= 0) {
      for (int m : {2, 5}) {
        const double v = m * std::pow(10, e);
        if (v <= scale.high) out.push_back({v, fmt::format("{:g}", v)});
      }
    }
  }
  return out;
}

/// Outlines in units of the marker's size, y down; drawn closed. The first is drawn as a circle,
/// the two crosses as lines.
struct Outline {
  double size;
  std::vector<std::array<double, 2>> corners;
};
const std::vector<Outline>& outlines() {
  static const std::vector<Outline> all = {
      {3.6, {}},                                                               // circle
      {3.4, {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}},                             // square
      {4.4, {{0, -1}, {1, 0.8}, {-1, 0.8}}},                                   // triangle
      {4.8, {{0, -1}, {0.8, 0}, {0, 1}, {-0.8, 0}}},                           // diamond
      {4.4, {{0, 1}, {1, -0.8}, {-1, -0.8}}},                                  // down
      {3.6, {{-1, -1}, {1, 1}, {0, 0}, {1, -1}, {-1, 1}, {0, 0}}},             // x
      {4.4, {{-1, 0}, {1, 0}, {0, 0}, {0, -1}, {0, 1}, {0, 0}}},               // plus
      {4.4, {{-0.9, 0}, {0.9, -1}, {0.9, 1}}},                                 // left
      {4.4, {{0.9, 0}, {-0.9, -1}, {-0.9, 1}}},                                // right
      {4.2, {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}}},                             // hourglass
      {4.2, {{-1, -1}, {-1, 1}, {1, -1}, {1, 1}}},                             // bow tie
      {5.0, {{-1, -0.4}, {1, -0.4}, {1, 0.4}, {-1, 0.4}}},                     // bar
      {5.0, {{-0.4, -1}, {0.4, -1}, {0.4, 1}, {-0.4, 1}}},                     // column
      {4.4, {{0, -1}, {0.95, -0.3}, {0.6, 0.8}, {-0.6, 0.8}, {-0.95, -0.3}}},  // pentagon
      {5.4,                                                                    // star
       {{0, -1},
        {0.24, -0.24},
        {1, 0},
        {0.24, 0.24},
        {0, 1},
        {-0.24, 0.24},
        {-1, 0},
        {-0.24, -0.24}}},
      {4.2, {{-1, 1}, {-1, -1}, {1, 1}}},  // corner
  };
  return all;
}

// Beyond eight styles the colours come again, with other dashes.
const char* colour_of(int style) {
  return kColours[static_cast<std::size_t>(style) % kColours.size()];
}
const char* dashes_of(int style) {
  return kDashes[static_cast<std::size_t>(style % 8 + 2 * (style / 8)) % kDashes.size()];
}

std::string marker(int style, double x, double y, bool hollow) {
  const char* colour = colour_of(style);
  const Outline& outline = outlines()[static_cast<std::size_t>(style) % outlines().size()];
  if (outline.corners.empty()) {
    return fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\" stroke=\"{}\" "
        "stroke-width=\"1.3\"/>",
        x, y, outline.size, hollow ? "#fff" : colour, colour);
  }
  std::string path;
  for (const auto& [cx, cy] : outline.corners) {
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x + outline.size * cx,
                        y + outline.size * cy);
  }
  const bool lines = style % 16 == 5 || style % 16 == 6;  // nothing to fill: thin means empty
  return fmt::format("<path d=\"{}z\" fill=\"{}\" stroke=\"{}\" stroke-width=\"{}\"/>", path,
                     hollow || lines ? "#fff" : colour, colour, lines && !hollow ? 2.2 : 1.3);
}

}  // namespace

std::string escape_markup(const std::string& text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string to_svg(const Chart& chart) {
  std::vector<double> xs, ys;
  for (const ChartSeries& series : chart.series) {
    for (const ChartPoint& p : series.points) {
      if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
      xs.push_back(p.x);
      ys.push_back(p.y);
    }
  }
  if (chart.y_line) ys.push_back(*chart.y_line);
  const Scale x = make_scale(chart.x, xs, kLeft, kWidth - kRight);
  const Scale y = make_scale(chart.y, ys, kHeight - kBottom, kTop);
  const int legend_rows =
      (static_cast<int>(chart.series.size()) + kLegendColumns - 1) / kLegendColumns;
  const double height = kHeight + kLegendRow * legend_rows + 4;

  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" font-size=\"11\" "
      "font-family=\"system-ui, sans-serif\">\n",
      kWidth, height, escape_markup(chart.title));
  const double bottom = kHeight - kBottom;
  for (const Tick& t : ticks(chart.x, x)) {
    svg += fmt::format(
        "<path d=\"M{0:.1f} {1}V{2}\" stroke=\"#e3e3e3\"/><text x=\"{0:.1f}\" y=\"{3}\" "
        "text-anchor=\"middle\">{4}</text>\n",
        x(t.value), kTop, bottom, bottom + 15, t.label);
  }
  for (const Tick& t : ticks(chart.y, y)) {
    svg += fmt::format(
        "<path d=\"M{1} {0:.1f}H{2}\" stroke=\"#e3e3e3\"/><text x=\"{3}\" y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5}</text>\n",
        y(t.value), kLeft, kWidth - kRight, kLeft - 5, y(t.value) + 4, t.label);
  }
  svg += fmt::format(
      "<path d=\"M{0} {1}V{2}H{3}\" fill=\"none\" stroke=\"#444\"/>"
      "<text x=\"{4}\" y=\"{5}\" text-anchor=\"middle\">{6}</text>"
      "<text transform=\"translate(12 {7}) rotate(-90)\" text-anchor=\"middle\">{8}</text>\n",
      kLeft, kTop, bottom, kWidth - kRight, 0.5 * (kLeft + kWidth - kRight), kHeight - 9,
      escape_markup(chart.x.label), 0.5 * (kTop + bottom), escape_markup(chart.y.label));
  if (chart.y_line && std::isfinite(*chart.y_line)) {
    svg += fmt::format(
        "<path d=\"M{0} {1:.1f}H{2}\" stroke=\"#888\" stroke-dasharray=\"1 3\" "
        "stroke-width=\"1.5\"/><text x=\"{2}\" y=\"{3:.1f}\" text-anchor=\"end\" fill=\"#555\" "
        "font-size=\"9.5\">{4}</text>\n",
        kLeft, y(*chart.y_line), kWidth - kRight, y(*chart.y_line) - 3,
        escape_markup(chart.y_line_label));
  }
  for (const ChartSeries& series : chart.series) {
    std::string path, markers;
    for (const ChartPoint& p : series.points) {
      if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
      const double px = x(p.x), py = y(p.y);
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", px, py);
      if (p.marked) {
        markers += fmt::format("<g><title>{}</title>{}</g>", escape_markup(p.note),
                               marker(series.style, px, py, p.hollow));
      }
    }
    if (path.empty()) continue;
    svg += fmt::format(
        "<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.4\" "
        "stroke-dasharray=\"{}\"/>{}\n",
        path, colour_of(series.style), dashes_of(series.style), markers);
  }
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const ChartSeries& series = chart.series[i];
    const double lx = 6 + static_cast<double>(i % kLegendColumns) * (kWidth - 6) / kLegendColumns;
    const double ly = kHeight + 8 + kLegendRow * static_cast<double>(i / kLegendColumns);
    svg += fmt::format(
        "<path d=\"M{:.1f} {:.1f}h22\" stroke=\"{}\" stroke-width=\"1.4\" "
        "stroke-dasharray=\"{}\"/>{}<text x=\"{:.1f}\" y=\"{:.1f}\" font-size=\"10\">{}</text>\n",
        lx, ly, colour_of(series.style), dashes_of(series.style),
        marker(series.style, lx + 11, ly, false), lx + 26, ly + 3.5, escape_markup(series.name));
  }
  return svg + "</svg>\n";
}

}  // namespace bipot
