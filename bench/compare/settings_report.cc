#include "bench/compare/settings_report.h"

#include <fmt/format.h>

#include "bench/measure/statistics.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

/// Values of the runs of one setting; those that are not finite are left out.
template <class Value>
std::vector<double> sorted_values(const SettingStudy& study, const std::string& code,
                                  const Value& value) {
  std::vector<double> values;
  for (const SettingStudy::Row& row : study.rows) {
    if (row.code == code && std::isfinite(value(row))) values.push_back(value(row));
  }
  std::ranges::sort(values);
  return values;
}

double guarded_of(const SettingStudy::Row& row) { return row.error.guarded(); }

/// NaN if it was not measured.
double column_overlap(const SettingStudy& study, const std::string& code) {
  for (const SettingStudy::Overlap& o : study.overlaps) {
    if (o.code == code && o.scene == SettingStudy::Overlap::kColumn) return o.largest;
  }
  return kNaN;
}

Table settings_table(const SettingStudy& study) {
  Table table{.columns = {{.key = "code", .name = "default of"},
                          {.key = "rule", .name = "it stops at"},
                          {.key = "met", .name = "its test met", .show = count_label},
                          {.key = "runs", .name = "problems", .show = count_label},
                          {.key = "iterations", .name = "iterations", .show = count_label},
                          {.key = "guarded", .name = "max(ε, η)", .show = error_label},
                          {.key = "guarded_10", .name = "10 %", .show = error_label},
                          {.key = "guarded_90", .name = "90 %", .show = error_label},
                          {.key = "epsilon", .name = "ε", .show = error_label},
                          {.key = "eta", .name = "η", .show = error_label},
                          {.key = "natural_map", .name = "natural map", .show = error_label},
                          {.key = "force", .name = "force error", .show = error_label},
                          {.key = "overlap", .name = "overlap", .show = error_label}},
              .key = "settings",
              .caption = "Your code's default, in ε",
              .note =
                  "Medians over the problems; 10 % and 90 % of the problems have no larger "
                  "max(ε, η). Force error: of the resultant on a body, over the largest. "
                  "Overlap: of a column at rest after 100 steps, over the smallest radius."};
  for (const PopularSetting& setting : popular_settings()) {
    const auto middle = [&](const auto& value) {
      return sorted_median(sorted_values(study, setting.code, value));
    };
    const std::vector<double> guarded = sorted_values(study, setting.code, guarded_of);
    const auto met = std::ranges::count_if(study.rows, [&](const SettingStudy::Row& r) {
      return r.code == setting.code && r.end == "test";
    });
    const auto runs = std::ranges::count_if(
        study.rows, [&](const SettingStudy::Row& r) { return r.code == setting.code; });
    Table::Cell met_cell(met);
    if (setting.test == PopularSetting::Test::kNone) met_cell = Table::Cell("none");
    table.add({setting.code, setting.rule, met_cell, runs,
               middle([](const SettingStudy::Row& r) { return static_cast<double>(r.iterations); }),
               sorted_median(guarded), quantile(guarded, 0.1), quantile(guarded, 0.9),
               middle([](const SettingStudy::Row& r) { return r.error.epsilon; }),
               middle([](const SettingStudy::Row& r) { return r.error.eta; }),
               middle([](const SettingStudy::Row& r) { return r.error.natural_map; }),
               middle([](const SettingStudy::Row& r) { return r.true_error.force; }),
               column_overlap(study, setting.code)});
  }
  return table;
}

/// Scenes side by side, a line for each setting.
Table overlaps_table(const SettingStudy& study) {
  Table table{.columns = {{.key = "code", .name = "steps end at"}},
              .key = "overlaps",
              .caption = "Overlap after 100 steps",
              .note =
                  "Over the smallest radius, from a start without overlaps: the largest, and the "
                  "mean of the pairs that overlap. First line: steps solved to 1e-8; its overlaps "
                  "are those of the time step."};
  std::vector<std::string> codes;
  std::map<std::string, std::vector<Table::Cell>> lines;
  for (const SettingStudy::Overlap& o : study.overlaps) {
    if (lines.empty() || o.code == codes.front()) {
      const std::string key = fmt::format("scene{}", table.columns.size() / 2 + 1);
      table.columns.push_back(
          {.key = key + "_largest", .name = o.scene + ": largest", .show = error_label});
      table.columns.push_back({.key = key + "_mean", .name = "mean", .show = error_label});
    }
    if (!lines.contains(o.code)) {
      codes.push_back(o.code);
      lines[o.code].emplace_back(o.code);
    }
    lines[o.code].emplace_back(o.largest);
    lines[o.code].emplace_back(o.mean);
  }
  for (const std::string& code : codes) table.add(lines[code]);
  return table;
}

Table tolerance_table(const SettingStudy& study) {
  Table table{.columns = {{.key = "test", .name = "tolerance of"},
                          {.key = "tol", .name = "T", .show = tolerance_label},
                          {.key = "problems", .name = "problems", .show = count_label},
                          {.key = "guarded", .name = "max(ε, η)", .show = error_label},
                          {.key = "guarded_10", .name = "10 %", .show = error_label},
                          {.key = "guarded_90", .name = "90 %", .show = error_label}},
              .key = "tolerances",
              .caption = "What a tolerance of another code means",
              .note =
                  "Error of the first tested iterate whose own measure is at most T: median, "
                  "and what 10 % and 90 % of the problems do not exceed, of those that got there. "
                  "LMGC90 tests every 50 iterations, SCoPI every 80."};
  for (const PopularSetting& setting : popular_settings()) {
    if (setting.test == PopularSetting::Test::kNone) continue;
    for (std::size_t i = 0; i < SettingStudy::kTolerances.size(); ++i) {
      const std::vector<double> at = sorted_values(
          study, setting.code, [&](const SettingStudy::Row& r) { return r.at_tolerance[i]; });
      if (at.empty()) continue;
      table.add({to_string(setting.test), SettingStudy::kTolerances[i], at.size(),
                 sorted_median(at), quantile(at, 0.1), quantile(at, 0.9)});
    }
  }
  return table;
}

/// Points: the problems. Line: median, from 10 % to 90 % of them.
Chart settings_chart(const SettingStudy& study) {
  Chart chart{.title = "Error of popular settings",
              .x = {.label = "setting", .low = 0.5},
              .y = {.label = "max(ε, η)", .kind = Chart::Axis::Kind::kLog, .low = 1e-10},
              .y_lines = {{1e-2, ""}, {1e-6, ""}},
              .key = Chart::Key::kRight,
              .width = 640,
              .height = 360};
  const auto& settings = popular_settings();
  chart.x.high = static_cast<double>(settings.size()) + 0.5;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    const double x = static_cast<double>(i) + 1;
    Chart::Series series{
        .name = fmt::format("{} {}: {}", i + 1, settings[i].code, settings[i].rule),
        .style = static_cast<int>(i),
        .kind = Chart::Series::Kind::kPoints};
    for (const SettingStudy::Row& row : study.rows) {
      if (row.code != settings[i].code || !std::isfinite(guarded_of(row))) continue;
      series.points.push_back(
          {.x = x - 0.15,
           .y = guarded_of(row),
           .hollow = true,
           .note = fmt::format("{}: {}", row.problem, error_label(guarded_of(row)))});
    }
    const std::vector<double> guarded = sorted_values(study, settings[i].code, guarded_of);
    if (!guarded.empty()) {
      series.points.push_back({.x = x + 0.15,
                               .y = sorted_median(guarded),
                               .note = "median, 10 % to 90 %",
                               .y_low = quantile(guarded, 0.1),
                               .y_high = quantile(guarded, 0.9)});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

Table setting_rows(const SettingStudy& study) {
  Table table{.columns = {{.key = "problem", .name = "problem", .filter = true},
                          {.key = "contacts", .name = "contacts", .show = count_label},
                          {.key = "dim", .name = "d", .show = count_label},
                          {.key = "code", .name = "default of", .filter = true},
                          {.key = "end", .name = "ended by"},
                          {.key = "iterations", .name = "iterations", .show = count_label},
                          {.key = "own", .name = "its measure", .show = error_label},
                          {.key = "epsilon", .name = "ε", .show = error_label},
                          {.key = "eta", .name = "η", .show = error_label},
                          {.key = "natural_map", .name = "natural map", .show = error_label},
                          {.key = "velocity", .name = "velocity error", .show = error_label},
                          {.key = "force", .name = "force error", .show = error_label},
                          {.key = "penetration", .name = "overlap", .show = error_label}},
              .key = "rows",
              .sortable = true};
  for (const SettingStudy::Row& r : study.rows) {
    table.add({r.problem, r.contacts, r.dim, r.code, r.end, r.iterations, r.own, r.error.epsilon,
               r.error.eta, r.error.natural_map, r.true_error.velocity, r.true_error.force,
               r.true_error.penetration});
  }
  return table;
}

Document settings_document(const SettingStudy& study, const Provenance& made) {
  Document page{.title = "Popular settings, judged", .made = made};
  page.say(
      "Each setting is run by a solver of this project, as the manual says (reference, settings), "
      "and its impulse is judged by the criterion of exact Coulomb friction.");
  page.add(settings_table(study));
  page.add(Figure{.chart = settings_chart(study),
                  .file = "popular.svg",
                  .caption = "Your code's default, in ε. Hollow: one problem. Filled: the median, "
                             "with the range of 80 % of the problems.",
                  .source = "settings.csv",
                  .wide = true});
  page.add(tolerance_table(study));
  if (!study.overlaps.empty()) page.add(overlaps_table(study));
  for (const SettingStudy::Overlap& o : study.overlaps) {
    if (!o.end.empty()) page.say(fmt::format("{}, {}: {}", o.scene, o.code, o.end));
  }
  for (const std::string& defect : study.defects) page.say("Left out: " + defect);
  return page;
}

}  // namespace bipot
