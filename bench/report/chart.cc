#include "bench/report/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <string_view>

#include "bench/report/csv_text.h"
#include "bench/report/program.h"
#include "bench/report/text_lines.h"
#include "core/base/file_error.h"
#include "core/base/number_text.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

// Colours, markers and dashes repeat together after 210 styles only. Colours: first those of Okabe
// and Ito for the colour-blind, without yellow, which is invisible on white; one for each solver.
constexpr std::array<const char*, 14> kColours = {
    "#000000", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00",
    "#6a3d9a", "#8c510a", "#b2182b", "#1b5e20", "#e7298a", "#777777", "#8a8a00"};
struct Marker {
  int filled, hollow;  // gnuplot's point types
  double size;         // to look alike
};
constexpr std::array<Marker, 6> kMarkers = {
    {{7, 6, 0.62}, {5, 4, 0.58}, {9, 8, 0.72}, {13, 12, 0.8}, {11, 10, 0.72}, {15, 14, 0.68}}};
constexpr std::array<const char*, 5> kDashes = {"solid", "(10,5)", "(2,4)", "(12,4,2,4)", "(18,6)"};

constexpr double kKeyRow = 17, kKeySample = 42, kLetter = 6.6;  // of the key, in the chart's units

template <class Array>
const auto& of_style(const Array& all, int style) {
  return all[static_cast<std::size_t>(std::max(0, style)) % all.size()];
}

/// Text for gnuplot: in single quotes only the quote has a meaning. Control characters become
/// spaces.
std::string in_quotes(std::string_view text) {
  std::string out = "'";
  for (char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '\'') out += '\'';
    out += code < 0x20 || code == 0x7f ? ' ' : c;
  }
  return out + '\'';
}

/// Lines of at most `width` letters, as an expression of gnuplot.
std::string wrapped(const std::string& text, std::size_t width) {
  std::string out;
  for (const std::string& line : wrapped_lines(text, width)) {
    out += (out.empty() ? "" : ".\"\\n\".") + in_quotes(line);
  }
  return out;
}

bool is_log(const Chart::Axis& axis) { return axis.kind != Chart::Axis::Kind::kLinear; }

/// True if a reference line lies within the given limits.
bool allows(const Chart::Axis& axis, double at) {
  return std::isfinite(at) && !(is_log(axis) && at <= 0) && !(axis.low && at < *axis.low) &&
         !(axis.high && at > *axis.high);
}

/// Place of non-positive values on a logarithmic axis: its limit, or the decade below all others.
double floor_of(const Chart::Axis& axis, const std::vector<double>& values) {
  if (axis.low && *axis.low > 0) return *axis.low;
  double least = std::numeric_limits<double>::infinity();
  for (double v : values) {
    if (v > 0) least = std::min(least, v);
  }
  if (!std::isfinite(least)) least = axis.high && *axis.high > 0 ? *axis.high / 10 : 1e-3;
  return std::pow(10, std::floor(std::log10(least) + 1e-9));
}

/// The chart as input of gnuplot. `page`: for the element of a page, with the points' notes as
/// labels "n<series>_<point>" that are replaced later; else a file with its title.
class Script {
 public:
  Script(const Chart& chart, bool page) : chart_(chart), page_(page) {
    for (const Chart::Series& series : chart.series) {
      for (const Chart::Point& p : series.points) {
        if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
        xs_.push_back(p.x);
        ys_.push_back(p.y);
        if (!std::isfinite(p.y_low) || !std::isfinite(p.y_high)) continue;
        ys_.push_back(p.y_low);
        ys_.push_back(p.y_high);
      }
    }
    std::vector<double> places = xs_;
    for (const Chart::Line& line : chart.x_lines) places.push_back(line.at);
    if (is_log(chart.x)) x_floor_ = floor_of(chart.x, places);
    std::vector<double> levels = ys_;
    for (const Chart::Line& line : horizontal()) levels.push_back(line.at);
    if (is_log(chart.y)) y_floor_ = floor_of(chart.y, levels);
  }

  std::string write() {
    plan_key();
    line("reset");
    line(line_key_);
    line("set encoding utf8");
    line("set minussign");
    line(fmt::format("set terminal svg enhanced size {:.0f},{:.0f} font 'sans-serif,12'{}", width_,
                     height_, page_ ? "" : " background '#ffffff'"));
    line("set border 3 lc rgb '#444444'");
    line("set tics nomirror scale 0.6 textcolor rgb '#1b1b1b'");
    line("set grid lt 1 lc rgb '#e3e3e3'");
    line("set samples 2");
    line("set clip two");
    if (!page_ && !chart_.title.empty()) {
      const auto fits = static_cast<std::size_t>(std::max(20.0, width_ / kLetter));
      line(fmt::format("set title {} noenhanced", wrapped(chart_.title, fits)));
    }
    x_middle_ = axis("x", chart_.x, x_floor_);
    y_middle_ = axis("y", chart_.y, y_floor_);
    vertical_lines();
    for (bool background : {true, false}) {
      for (std::size_t i = 0; i < chart_.series.size(); ++i) {
        if (chart_.series[i].background == background) series(i);
      }
    }
    // Constant functions count for the range of the axis.
    for (const Chart::Line& reference : horizontal()) {
      add_plot(fmt::format("{} with lines lw 1.5 dt (1,4) lc rgb '#777777' notitle",
                           number(reference.at)),
               reference.label);
      if (reference.label.empty()) continue;
      line(
          fmt::format("set label {} at graph 0.99, first {} right offset 0,0.5 noenhanced font "
                      "',10' textcolor rgb '#555555' front",
                      in_quotes(reference.label), number(reference.at)));
    }
    if (xs_.empty()) {
      line("set label 'no finite values' at graph 0.5,0.5 center textcolor rgb '#555555'");
      if (plots_.empty()) add_plot("NaN notitle", "");
    }
    for (const auto& serie : chart_.series) key_entry(serie);
    std::string plot = "plot ";
    for (std::size_t i = 0; i < plots_.size(); ++i) plot += (i == 0 ? "" : ", \\\n  ") + plots_[i];
    line(plot);
    return std::move(text_);
  }

  double width() const { return width_; }
  double height() const { return height_; }
  /// Text that the pointer shows on each plot, in their order.
  const std::vector<std::string>& tips() const { return tips_; }

 private:
  void line(std::string_view text) {
    text_ += text;
    text_ += '\n';
  }

  void add_plot(std::string plot, std::string tip) {
    plots_.push_back(std::move(plot));
    tips_.push_back(std::move(tip));
  }

  static std::string number(double x) { return fmt::format("{}", x); }

  std::vector<Chart::Line> horizontal() const {
    std::vector<Chart::Line> lines = chart_.y_lines;
    std::erase_if(lines, [this](const Chart::Line& l) { return !allows(chart_.y, l.at); });
    return lines;
  }

  double lifted_x(double x) const { return is_log(chart_.x) ? std::max(x, x_floor_) : x; }
  double lifted_y(double y) const { return is_log(chart_.y) ? std::max(y, y_floor_) : y; }

  /// gnuplot takes the room of the key from the axes: the drawing grows by as much.
  void plan_key() {
    width_ = chart_.width;
    height_ = chart_.height;
    if (!page_ && !chart_.title.empty()) height_ += 30;
    double longest = 0;
    int entries = 0;
    for (const Chart::Series& s : chart_.series) {
      if (s.name.empty()) continue;
      ++entries;
      longest = std::max(longest, static_cast<double>(letters(s.name)));
    }
    if (entries == 0 || chart_.key == Chart::Key::kNone) {
      line_key_ = "unset key";
      return;
    }
    const double entry = kKeySample + kLetter * longest;
    if (chart_.key == Chart::Key::kRight) {
      width_ += entry;
      height_ = std::max(height_, kKeyRow * entries + 20);
      line_key_ = "set key outside right top vertical";
    } else {
      const int columns = std::clamp(static_cast<int>(width_ / entry), 1, entries);
      const int rows = (entries + columns - 1) / columns;
      height_ += kKeyRow * (rows + 1);
      // By rows: gnuplot limits columns to those that fit below the axes.
      line_key_ = fmt::format("set key outside below center vertical height 1 maxrows {}", rows);
    }
    line_key_ += " Left reverse samplen 2 spacing 1.15 font ',10.5' textcolor rgb '#1b1b1b'";
  }

  /// Returns the middle of the axis.
  double axis(const char* name, const Chart::Axis& axis, double floor) {
    const bool along_x = name[0] == 'x';
    line(fmt::format("set {}label {} noenhanced{}", name, in_quotes(axis.label),
                     along_x ? " offset 0,0.4" : ""));
    std::string low = "*", high = "*";
    if (axis.low && (!is_log(axis) || *axis.low > 0)) low = number(*axis.low);
    if (axis.high && (!is_log(axis) || *axis.high > 0)) high = number(*axis.high);
    if (is_log(axis)) line(fmt::format("set logscale {}", name));
    switch (axis.kind) {
      case Chart::Axis::Kind::kLinear:
        break;
      case Chart::Axis::Kind::kLog:
        line(fmt::format("set format {} '10^{{%T}}'", name));
        break;
      case Chart::Axis::Kind::kLogSeconds:
        line(fmt::format("set format {} '%.0s %cs'", name));
        // gnuplot writes u for micro.
        line(fmt::format("set {}tics add ('1 µs' 1e-6, '10 µs' 1e-5, '100 µs' 1e-4)", name));
        break;
    }
    // An axis without data, or with one value, needs a range.
    std::vector<double> values = along_x ? xs_ : ys_;
    for (const Chart::Line& l : along_x ? chart_.x_lines : horizontal()) {
      if (allows(axis, l.at)) values.push_back(l.at);
    }
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (double v : values) {
      if (!std::isfinite(v)) continue;
      if (is_log(axis)) v = std::max(v, floor);
      least = std::min(least, v);
      most = std::max(most, v);
    }
    if (low != "*") least = *axis.low;
    if (high != "*") most = *axis.high;
    if (!std::isfinite(least) || !std::isfinite(most)) {
      least = is_log(axis) ? floor : 0;
      most = is_log(axis) ? 10 * floor : 1;
      low = number(least);
      high = number(most);
    } else if (is_log(axis)) {
      // Whole decades; gnuplot's own rounding adds one where a limit is met exactly.
      const double first = std::floor(std::log10(least) + 1e-9);
      const double last = std::max(std::ceil(std::log10(most) - 1e-9), first + 1);
      if (low == "*") low = number(std::pow(10, first));
      if (high == "*") high = number(std::pow(10, last));
      if (last - first > 8) line(fmt::format("unset m{}tics", name));
    } else if (!(most > least)) {
      const double margin = least == 0 ? 1 : 0.5 * std::abs(least);
      if (!axis.low) low = number(least - margin);
      if (!axis.high) high = number(least + margin);
    }
    line(fmt::format("set {}range [{}:{}]", name, low, high));
    const double first = low == "*" ? least : number_at(low);
    const double last = high == "*" ? most : number_at(high);
    return is_log(axis) ? std::sqrt(first) * std::sqrt(last) : 0.5 * (first + last);
  }

  /// gnuplot leaves out labels on the frame, and markers with notes are labels: they are moved
  /// inwards by an invisible amount.
  static double inside(const Chart::Axis& axis, double v, double middle) {
    constexpr double kShift = 1e-9;
    return is_log(axis) ? v * std::pow(middle / v, kShift) : v + kShift * (middle - v);
  }

  void vertical_lines() {
    for (const Chart::Line& reference : chart_.x_lines) {
      if (!allows(chart_.x, reference.at)) continue;
      const std::string at = number(reference.at);
      line(
          fmt::format("set arrow from first {0}, graph 0 to first {0}, graph 1 nohead lw 1.5 dt "
                      "(1,4) lc rgb '#777777'",
                      at));
      if (!reference.label.empty()) {
        line(
            fmt::format("set label {} at first {}, graph 0.02 left rotate by 90 offset 1,0 "
                        "noenhanced font ',10' textcolor rgb '#555555' front",
                        in_quotes(reference.label), at));
      }
      // Arrows do not widen the range, invisible data do.
      if (ys_.empty()) continue;
      const std::string block = fmt::format("$v{}", plots_.size());
      line(fmt::format("{} << EOD\n{} {}\nEOD", block, at, number(lifted_y(ys_.front()))));
      add_plot(block + " using 1:2 with points pt -1 notitle", "");
    }
  }

  static std::string line_style(const Chart::Series& s) {
    if (s.background) return "lw 7 dt solid lc rgb '#d9d9d9'";
    return fmt::format("lw 1.6 dt {} lc rgb '{}'", of_style(kDashes, s.style),
                       of_style(kColours, s.style));
  }

  /// Points of one kind, as a block of data and the plot that draws it.
  void block(const std::string& name, const std::string& rows, const std::string& plot,
             const std::string& tip) {
    if (rows.empty()) return;
    line(fmt::format("{} << EOD\n{}EOD", name, rows));
    add_plot(name + " " + plot + " notitle", tip);
  }

  void series(std::size_t index) {
    const Chart::Series& s = chart_.series[index];
    using Kind = Chart::Series::Kind;
    std::string joined, bars;
    std::array<std::string, 2> marked;  // filled, hollow
    for (std::size_t k = 0; k < s.points.size(); ++k) {
      const Chart::Point& p = s.points[k];
      if (!std::isfinite(p.x) || !std::isfinite(p.y)) continue;
      const std::string at = number(lifted_x(p.x)) + " " + number(lifted_y(p.y));
      joined += at + "\n";
      if (std::isfinite(p.y_low) && std::isfinite(p.y_high)) {
        bars +=
            fmt::format("{} {} {}\n", at, number(lifted_y(p.y_low)), number(lifted_y(p.y_high)));
      }
      if (!p.marked || s.kind == Kind::kLine || s.background) continue;
      marked[p.hollow ? 1 : 0] +=
          page_ ? fmt::format("{} {} n{}_{}\n", inside(chart_.x, lifted_x(p.x), x_middle_),
                              inside(chart_.y, lifted_y(p.y), y_middle_), index, k)
                : at + "\n";
    }
    if (s.kind != Kind::kPoints) {
      block(fmt::format("$line{}", index), joined,
            fmt::format("using 1:2 with {} {}", s.kind == Kind::kSteps ? "steps" : "lines",
                        line_style(s)),
            s.name);
    }
    block(fmt::format("$bar{}", index), bars,
          fmt::format("using 1:2:3:4 with yerrorbars pt -1 lw 1 lc rgb '{}'",
                      of_style(kColours, s.style)),
          s.name);
    const Marker& marker = of_style(kMarkers, s.style);
    const char* colour = of_style(kColours, s.style);
    const auto look = [&](int type, const char* fill) {
      return fmt::format("pt {} ps {} lw 1.2 lc rgb '{}'", type, marker.size, fill);
    };
    const std::string with =
        page_ ? "using 1:2:3 with labels hypertext point " : "using 1:2 with points ";
    const std::string of = std::to_string(index);
    block("$filled" + of, marked[0], with + look(marker.filled, colour), s.name);
    if (marked[1].empty()) return;
    // White below, so that no line crosses an empty marker.
    const std::string empty = "$hollow" + of;
    block(empty, marked[1], "using 1:2 with points " + look(marker.filled, "#ffffff"), s.name);
    add_plot(empty + " " + with + look(marker.hollow, colour) + " notitle", s.name);
  }

  void key_entry(const Chart::Series& s) {
    if (s.name.empty() || chart_.key == Chart::Key::kNone) return;
    const bool any_marked =
        s.kind != Chart::Series::Kind::kLine && !s.background &&
        std::ranges::any_of(s.points, [](const Chart::Point& p) { return p.marked; });
    const bool joined = s.kind != Chart::Series::Kind::kPoints;
    const Marker& marker = of_style(kMarkers, s.style);
    std::string look = joined && any_marked ? "linespoints" : joined ? "lines" : "points";
    if (any_marked || !joined) look += fmt::format(" pt {} ps {}", marker.filled, marker.size);
    look +=
        " " + (joined ? line_style(s) : fmt::format("lc rgb '{}'", of_style(kColours, s.style)));
    add_plot(fmt::format("keyentry with {} title {} noenhanced", look, in_quotes(s.name)), s.name);
  }

  const Chart& chart_;
  const bool page_;
  std::vector<double> xs_, ys_;
  double x_floor_ = 0, y_floor_ = 0;
  double x_middle_ = 0, y_middle_ = 0;
  double width_ = 0, height_ = 0;
  std::string line_key_;
  std::string text_;
  std::vector<std::string> plots_, tips_;
};

/// FNV-1a, folded to 32 bits: the same text gets the same name on every machine.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 14695981039346656037u;
  for (char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return (hash ^ (hash >> 32)) & 0xffffffffu;
}

/// Note of the point with the label "n<series>_<point>"; else where it stands.
std::string note_of(const Chart& chart, std::string_view label) {
  const std::string text(label);
  char* end = nullptr;
  const std::size_t series = std::strtoul(text.c_str() + 1, &end, 10);
  const std::size_t point = std::strtoul(end + 1, nullptr, 10);
  const Chart::Series& s = chart.series.at(series);
  const Chart::Point& p = s.points.at(point);
  if (!p.note.empty()) return p.note;
  const auto named = [](const std::string& axis, double x) {
    return axis.empty() ? fmt::format("{:.4g}", x) : fmt::format("{}: {:.4g}", axis, x);
  };
  return fmt::format("{}{}{}, {}", s.name, s.name.empty() ? "" : "; ", named(chart.x.label, p.x),
                     named(chart.y.label, p.y));
}

/// Additional data of a drawing for a page.
struct Plan {
  double width, height;
  std::vector<std::string> tips;
  std::string prefix;
};

/// gnuplot's document as an element of a page, with ids that start with the prefix. gnuplot shows
/// labels at the pointer by a script; here they become titles, which browsers show by themselves.
std::string page_element(const Chart& chart, std::string_view document, const Plan& plan) {
  constexpr std::string_view kBody = "</desc>", kTitle = "<title>", kTitleEnd = "</title>";
  constexpr std::string_view kLabel = "<g onmousemove=\"gnuplot_svg.showHypertext(evt,'";
  const std::size_t body = document.find(kBody);
  if (body == std::string_view::npos) throw FileError("gnuplot", "", "wrote an unknown SVG");
  std::string svg(document.substr(body + kBody.size()));
  const std::size_t filters = svg.find("<filter");  // of boxed text, which charts do not have
  if (filters != std::string::npos) svg.erase(filters, svg.find("</defs>") - filters);
  for (std::size_t at; (at = svg.find(" id=\"gnuplot_")) != std::string::npos;) {
    svg.erase(at, svg.find('"', at + 5) + 1 - at);
  }
  svg = replaced(std::move(svg), " id='", " id='" + plan.prefix);
  svg = replaced(std::move(svg), "xlink:href='#", "href='#" + plan.prefix);
  svg = replaced(std::move(svg), "url(#", "url(#" + plan.prefix);
  // What holds anyway.
  for (const char* idle : {" stroke-linecap=\"butt\" stroke-linejoin=\"miter\"",
                           " stroke-width=\"1.00\"", " class=\"gridline\" "}) {
    svg = replaced(std::move(svg), idle, "");
  }
  // Groups that draw nothing have colours of the chart before.
  for (std::size_t end = 0; (end = svg.find(">\n</g>", end)) != std::string::npos;) {
    const std::size_t begin = svg.rfind('<', end);
    const bool empty = svg.compare(begin, 3, "<g ") == 0;
    if (empty) svg.erase(begin, end + 6 - begin);
    end = empty ? begin : end + 1;
  }
  svg.erase(svg.rfind('>') + 1);
  std::string out =
      fmt::format("<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">\n",
                  plan.width, plan.height, escape_markup(chart.title));
  std::size_t plot = 0;
  for (std::size_t begin = 0;;) {
    const std::size_t label = svg.find(kLabel, begin), title = svg.find(kTitle, begin);
    const std::size_t at = std::min(label, title);
    out.append(svg, begin, at == std::string::npos ? at : at - begin);
    if (at == std::string::npos) return out;
    const bool note = label < title;
    const std::string tip =
        note ? note_of(chart, svg.substr(label + kLabel.size(), 40)) : plan.tips.at(plot++);
    if (note) out += "<g>";
    if (!tip.empty()) out += "<title>" + escape_markup(tip) + "</title>";
    begin = svg.find(kTitleEnd, at) + kTitleEnd.size();
  }
}

}  // namespace

std::string to_svg(const Chart& chart) { return to_svg(std::span(&chart, 1)).front(); }

std::vector<std::string> to_svg(std::span<const Chart> charts) {
  if (charts.empty()) return {};
  std::vector<Plan> plans;
  std::set<std::string> prefixes;
  std::string all;
  for (const Chart& chart : charts) {
    Script script(chart, true);
    const std::string text = script.write();
    std::string prefix = fmt::format("c{:x}-", hash_of(text));
    for (int copy = 2; !prefixes.insert(prefix).second; ++copy) {
      prefix = fmt::format("c{:x}-{}-", hash_of(text), copy);
    }
    plans.push_back({script.width(), script.height(), script.tips(), std::move(prefix)});
    all += text;
  }
  const std::string documents = run_gnuplot(all);
  constexpr std::string_view kStart = "<?xml";
  std::vector<std::string> out;
  std::size_t begin = documents.find(kStart);
  for (std::size_t i = 0; i < charts.size(); ++i) {
    if (begin == std::string::npos) throw FileError("gnuplot", "", "wrote fewer charts than asked");
    const std::size_t next = documents.find(kStart, begin + 1);
    const auto document = std::string_view(documents).substr(begin, next - begin);
    out.push_back(page_element(charts[i], document, plans[i]));
    begin = next;
  }
  return out;
}

void write_chart_data(const std::filesystem::path& folder, const std::string& name,
                      const Chart& chart) {
  // The output is named after the terminal.
  write_text_file(folder / (name + ".gp"),
                  fmt::format("# gnuplot {0}.gp makes {0}.svg.\nset output {1}\n{2}", name,
                              in_quotes(name + ".svg"), Script(chart, false).write()));
  std::string csv = "series,x,y,note\n";
  for (const Chart::Series& series : chart.series) {
    for (const Chart::Point& p : series.points) {
      csv += fmt::format("{},{},{},{}\n", csv_text(series.name), p.x, p.y, csv_text(p.note));
    }
  }
  write_text_file(folder / (name + ".csv"), csv);
}

void write_chart_files(const std::filesystem::path& folder, const std::string& name,
                       const Chart& chart) {
  write_chart_data(folder, name, chart);
  write_text_file(folder / (name + ".svg"), run_gnuplot(Script(chart, false).write()));
}

void require_plotting_tool() {
  const std::string version = run_gnuplot("set print '-'\nprint GPVAL_VERSION\n");
  if (!(number_at(version) >= 5.4)) {
    throw FileError("gnuplot", "", fmt::format("version {}, expected 5.4 or later", version));
  }
}

}  // namespace bipot
