#include "bench/experiments/validation_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/validation_page.h"
#include "bench/report/csv_text.h"
#include "bench/report/labels.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

constexpr double kChartFloor = 1e-12, kHighestFloor = 1e-4;

/// A number of a CSV file: empty where it is undefined, inf where it has no end.
std::string csv_number(double x) {
  if (std::isnan(x)) return "";
  return fmt::format("{:.10g}", x);
}

}  // namespace

std::string to_csv(const ValidationPage& page) {
  std::string csv =
      "group,row,tol,measured,bar,expected_low,expected_high,scale,error,right,reached,steps,unsolved,"
      "cpu_seconds,rows_in_run,solver,message\n";
  for (const ValidationVerdict& v : page.verdicts) {
    for (const ValidationPoint& p : v.points) {
      csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                         csv_text(v.row.group), v.row.name, csv_number(p.tol),
                         csv_number(p.seen.value), csv_number(p.seen.bar),
                         csv_number(v.row.expected.low), csv_number(v.row.expected.high),
                         csv_number(v.row.expected.scale), csv_number(p.error), p.right ? 1 : 0,
                         p.reached() ? 1 : 0, p.steps, p.unsolved, csv_number(p.seconds), v.shared,
                         page.solver, csv_text(p.failure.empty() ? p.seen.note : p.failure));
    }
  }
  return csv;
}

std::string verdicts_csv(const ValidationPage& page) {
  std::string csv =
      "group,row,quantity,source,expected,measured,bar,bar_is,at_tol,error,allowed,allowed_why,holds,"
      "reason,loosest_tol,steps,cpu_seconds,rows_in_run\n";
  for (const ValidationVerdict& v : page.verdicts) {
    const ValidationPoint* p = v.measured();
    csv += fmt::format(
        "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_text(v.row.group),
        v.row.name, csv_text(v.row.quantity), csv_text(v.row.source), csv_text(v.row.formula),
        p == nullptr ? "" : csv_number(p->seen.value), p == nullptr ? "" : csv_number(p->seen.bar),
        csv_text(v.row.bar), p == nullptr ? "" : csv_number(p->tol),
        p == nullptr ? "" : csv_number(p->error), csv_number(v.row.allowed),
        csv_text(v.row.allowed_why),
        v.holds       ? "yes"
        : v.undecided ? "undecided"
                      : "no",
        csv_text(v.reason), csv_number(v.row.takes_tolerance ? v.loosest : kNaN),
        p == nullptr ? 0 : p->steps, csv_number(v.seconds), v.shared);
  }
  return csv;
}

std::string to_text(const ValidationPage& page) {
  std::string text, group;
  for (const ValidationVerdict& v : page.verdicts) {
    if (v.row.group != group) {
      group = v.row.group;
      text += fmt::format("{}\n  {:<23} {:>10} {:>9} {:>9}  {:<14} {:>11} {:>8}\n", group, "",
                          "measured", "+-", "error", "", "right from", "CPU");
    }
    const ValidationPoint* p = v.measured();
    text += fmt::format(
        "  {:<23} {:>10} {:>9} {:>9}  {:<14} {:>11} {:>8}\n", v.row.name,
        p == nullptr ? "-" : value_label(p->seen.value),
        p == nullptr || p->seen.bar == 0 ? "" : compact_label(p->seen.bar),
        p == nullptr ? "-" : compact_label(p->error),
        v.holds       ? "holds"
        : v.undecided ? "undecided"
                      : "does not hold",
        !v.row.takes_tolerance || std::isnan(v.loosest) ? "-" : tolerance_label(v.loosest),
        fmt::format("{:.1f} s", v.seconds));
    if (!v.holds) text += fmt::format("    {}: {}\n", v.row.quantity, v.reason);
  }
  return text +
         fmt::format("{} of {} rows hold{}{}\n", page.held(), page.verdicts.size(),
                     page.undecided() > 0 ? fmt::format(", {} undecided", page.undecided()) : "",
                     page.complete ? "" : " (stopped before the end)");
}

std::vector<std::string> groups_of(const ValidationPage& page) {
  std::vector<std::string> groups;
  for (const ValidationVerdict& v : page.verdicts) {
    if (std::find(groups.begin(), groups.end(), v.row.group) == groups.end()) {
      groups.push_back(v.row.group);
    }
  }
  return groups;
}

std::string error_chart_name(const ValidationPage& page, const std::string& group) {
  const std::vector<std::string> groups = groups_of(page);
  const auto at = std::find(groups.begin(), groups.end(), group);
  return fmt::format("errors_{}", at - groups.begin() + 1);
}

Chart error_chart(const ValidationPage& page, const std::string& group) {
  Chart chart;
  chart.title = "Relative error against tolerance: " + group;
  chart.x = {.label = "tolerance ε of every step", .kind = ChartAxis::Kind::kLog};
  chart.y = {.label = "relative error of the observable", .kind = ChartAxis::Kind::kLog};
  chart.y_line = kRightTo;
  chart.y_line_label = "1 %";
  chart.key = Chart::Key::kRight;
  chart.width = 620;
  chart.height = 340;
  // A decade below the least error that is not 0, which stands on the axis.
  double least = kHighestFloor;
  for (const ValidationVerdict& v : page.verdicts) {
    for (const ValidationPoint& p : v.points) {
      if (v.row.group == group && p.error > 0) least = std::min(least, p.error);
    }
  }
  const double floor = std::max(kChartFloor, std::pow(10.0, std::floor(std::log10(0.3 * least))));
  chart.y.low = floor;
  int style = 0;
  for (const ValidationVerdict& v : page.verdicts) {
    if (v.row.group != group || !v.row.takes_tolerance) continue;
    ChartSeries series;
    series.name = v.row.name;
    series.style = style++;
    for (const ValidationPoint& p : v.points) {
      if (!std::isfinite(p.error)) continue;
      ChartPoint point;
      point.x = p.tol;
      point.y = std::max(p.error, floor);
      point.hollow = !p.reached();
      point.note = fmt::format(
          "{} at {}: {} (error {}){}", v.row.name, tolerance_label(p.tol),
          value_label(p.seen.value), compact_label(p.error),
          p.unsolved > 0 ? fmt::format(", {} of {} steps not solved", p.unsolved, p.steps) : "");
      series.points.push_back(point);
    }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

void write_validation(const std::filesystem::path& folder, const ValidationPage& page) {
  for (const std::string& group : groups_of(page)) {
    write_chart_files(folder, error_chart_name(page, group), error_chart(page, group));
  }
  for (const ValidationFigure& f : page.figures) write_chart_files(folder, f.name, f.chart);
  write_text_file(folder / "validate.csv", to_csv(page));
  write_text_file(folder / "verdicts.csv", verdicts_csv(page));
  write_text_file(folder / "index.html", to_html(page));
}

}  // namespace bipot
