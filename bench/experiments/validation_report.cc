#include "bench/experiments/validation_report.h"

#include <fmt/format.h>

#include "bench/measure/statistics.h"
#include "bench/report/labels.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

constexpr double kChartFloor = 1e-12, kHighestFloor = 1e-4;

/// Empty where it is undefined.
Table::Cell number(double x) { return std::isnan(x) ? Table::Cell() : Table::Cell(x); }

std::string verdict_of(const ValidationRow& row) {
  return row.holds() ? "holds" : row.undecided() ? "undecided" : "does not hold";
}

std::string right_from(const ValidationRow& row) {
  if (!row.takes_tolerance) return "no ε";
  return std::isnan(row.loosest) ? "none" : tolerance_label(row.loosest);
}

/// Notes of the page on a row.
std::string note_of(const ValidationRow& row) {
  std::string note;
  if (const ValidationRow::Point* p = row.measured()) {
    note = row.takes_tolerance ? fmt::format("at ε = {}, right from ε = {}",
                                             tolerance_label(p->tol), right_from(row))
                               : "no ε";
    note += fmt::format("\nrelative error {}, allowed {}: {}\n", compact_label(p->error),
                        compact_label(row.allowed), row.allowed_why);
    if (!p->seen.note.empty()) note += p->seen.note + "\n";
  }
  return note + fmt::format("`--only {}`", row.claim.name);
}

/// Every tolerance of every row of a group.
Findings::Table tolerances(const ValidationPage& page, const std::string& group) {
  Findings::Table table{.name = "tolerances",
                        .caption = "Every tolerance.",
                        .columns = {"row", "ε", "measured", "relative error", "right", "steps",
                                    "not solved", "CPU", "note"}};
  for (const ValidationRow& row : page.rows) {
    if (row.group != group) continue;
    for (const ValidationRow::Point& p : row.points) {
      table.rows.push_back({row.claim.name, tolerance_label(p.tol),
                            measured_text({.measured = p.seen.value, .bar = p.seen.bar}),
                            compact_label(p.error), p.right ? "✓" : "✗", std::to_string(p.steps),
                            std::to_string(p.unsolved), seconds_label(p.seconds),
                            p.failure.empty() ? p.seen.note : p.failure});
    }
  }
  return table;
}

template <class Holds>
int count_rows(const ValidationPage& page, const Holds& holds) {
  return static_cast<int>(std::ranges::count_if(page.rows, holds));
}

}  // namespace

void ValidationPage::add(Experiment::Result result) {
  auto& drawings = figures[result.rows.front().group];
  for (ValidationRow& row : result.rows) rows.push_back(std::move(row));
  for (Findings::Figure& figure : result.figures) drawings.push_back(std::move(figure));
}

int ValidationPage::held() const {
  return count_rows(*this, [](const ValidationRow& row) { return row.holds(); });
}

int ValidationPage::undecided() const {
  return count_rows(*this, [](const ValidationRow& row) { return row.undecided(); });
}

int ValidationPage::failed() const { return static_cast<int>(rows.size()) - held() - undecided(); }

Table points_table(const ValidationPage& page) {
  Table table{.columns =
                  Table::keyed({"group", "row", "tol", "measured", "bar", "expected_low",
                                "expected_high", "scale", "error", "right", "reached", "steps",
                                "unsolved", "cpu_seconds", "rows_in_run", "solver", "message"})};
  for (const ValidationRow& row : page.rows) {
    for (const ValidationRow::Point& p : row.points) {
      table.add({row.group, row.claim.name, p.tol, number(p.seen.value), number(p.seen.bar),
                 row.range.low, row.range.high, row.range.scale, number(p.error), p.right ? 1 : 0,
                 p.reached() ? 1 : 0, p.steps, p.unsolved, p.seconds, row.shared, page.solver,
                 p.failure.empty() ? p.seen.note : p.failure});
    }
  }
  return table;
}

Table verdicts_table(const ValidationPage& page) {
  Table table;
  table.columns = {{.key = "group"},
                   {.key = "row", .name = "row"},
                   {.key = "quantity"},
                   {.key = "source"},
                   {.key = "expected"},
                   {.key = "measured", .name = "measured", .show = &value_label},
                   {.key = "bar", .name = "±", .show = &compact_label},
                   {.key = "bar_is"},
                   {.key = "at_tol"},
                   {.key = "error", .name = "error", .show = &compact_label},
                   {.key = "allowed"},
                   {.key = "allowed_why"},
                   {.key = "holds", .name = "verdict"},
                   {.key = "reason"},
                   {.key = "loosest_tol", .name = "right from", .show = &tolerance_label},
                   {.key = "steps"},
                   {.key = "cpu_seconds", .name = "CPU", .show = &seconds_label},
                   {.key = "rows_in_run"}};
  const ValidationRow::Point none;
  const std::string* group = nullptr;
  for (const ValidationRow& row : page.rows) {
    if (group == nullptr || *group != row.group) {
      group = &row.group;
      table.add({*group});
    }
    const Claim& claim = row.claim;
    const bool any = row.measured() != nullptr;
    const ValidationRow::Point& p = any ? *row.measured() : none;
    const std::string holds = row.holds() ? "yes" : row.undecided() ? "undecided" : "no";
    table.add({row.group, claim.name, claim.quantity, claim.source, claim.expected,
               number(claim.measured).shown(value_label(claim.measured)),
               any ? Table::Cell(claim.bar).shown(claim.bar > 0 ? compact_label(claim.bar) : "")
                   : Table::Cell(),
               claim.bar_is, any ? Table::Cell(p.tol) : Table::Cell(),
               number(p.error).shown(compact_label(p.error)), row.allowed, row.allowed_why,
               Table::Cell(holds).shown(verdict_of(row)), claim.reason,
               number(row.takes_tolerance ? row.loosest : kNaN).shown(right_from(row)), p.steps,
               row.seconds, row.shared});
  }
  return table;
}

std::string to_text(const ValidationPage& page) {
  std::string text = to_text(verdicts_table(page));
  for (const ValidationRow& row : page.rows) {
    if (row.holds()) continue;
    text += fmt::format("{} {}: {}: {}\n", row.claim.name, verdict_of(row), row.claim.quantity,
                        row.claim.reason);
  }
  return text +
         fmt::format("{} of {} rows hold{}{}\n", page.held(), page.rows.size(),
                     page.undecided() > 0 ? fmt::format(", {} undecided", page.undecided()) : "",
                     page.complete ? "" : " (stopped before the end)");
}

std::vector<std::string> groups_of(const ValidationPage& page) {
  return distinct_in_order(page.rows, &ValidationRow::group);
}

Chart error_chart(const ValidationPage& page, const std::string& group) {
  Chart chart{.title = "Relative error against tolerance: " + group,
              .x = {.label = "tolerance ε of every step", .kind = Chart::Axis::Kind::kLog},
              .y = {.label = "relative error of the observable", .kind = Chart::Axis::Kind::kLog},
              .y_lines = {{kRightTo, "1 %"}}};
  // A decade below the least error other than 0, for the end of the axis.
  double least = kHighestFloor;
  for (const ValidationRow& row : page.rows) {
    for (const ValidationRow::Point& p : row.points) {
      if (row.group == group && p.error > 0) least = std::min(least, p.error);
    }
  }
  const double floor = std::max(kChartFloor, std::pow(10.0, std::floor(std::log10(0.3 * least))));
  chart.y.low = floor;
  int style = 0;
  for (const ValidationRow& row : page.rows) {
    if (row.group != group || !row.takes_tolerance) continue;
    Chart::Series series{.name = row.claim.name, .style = style++};
    for (const ValidationRow::Point& p : row.points) {
      if (!std::isfinite(p.error)) continue;
      Chart::Point point{
          .x = p.tol,
          .y = std::max(p.error, floor),
          .hollow = !p.reached(),
          .note = fmt::format("{} at {}: {} (error {}){}", row.claim.name, tolerance_label(p.tol),
                              value_label(p.seen.value), compact_label(p.error),
                              p.unsolved > 0
                                  ? fmt::format(", {} of {} steps not solved", p.unsolved, p.steps)
                                  : "")};
      series.points.push_back(point);
    }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

ClaimReport to_report(const ValidationPage& page) {
  ClaimReport report{.command = page.command,
                     .title = "Bipot: physics, checked: at which tolerance does it break?",
                     .complete = page.complete};
  report.introduction = fmt::format(
      "{} of {} rows hold, {} are undecided.{} Each row is an observable that theory, a proof or "
      "published work says something of. Every step is solved by `{}`, without islands, to the "
      "guarded error ε, for several ε.\n"
      "**Holds**: at the tightest ε that the steps reached (all but 1 % of them), the relative "
      "error is at most the allowed one and the error bar of the samples; the bar shown is their sum. "
      "**Undecided**: between one and two such bars, or a bar of more than half the scale. **Does not "
      "hold**: beyond two. **Right from**: the loosest ε from "
      "which on the error is at most 1 % (or the allowed one, if that is more) and the bar, at "
      "that and all tighter ones. For bounds "
      "the error is the distance outside, 0 inside. In figures, hollow marks are runs in which "
      "more than 1 % of the steps missed ε. An error of 0 stands on the axis. Values without a "
      "readable source are not tested; of those, an exponent or a derived bound is.\n{}"
      "[All numbers](validate.csv), [verdicts](verdicts.csv).",
      page.held(), page.rows.size(), page.undecided(),
      page.complete ? "" : " The measurement was stopped before its end.", page.solver,
      page.quick ? "This is the short form (`--quick`): fewer bodies, seeds and tolerances. "
                   "Statistical rows have wide bars.\n"
                 : "");
  for (const std::string& group : groups_of(page)) {
    ClaimReport::Item item{.name = fmt::format("errors_{}", report.items.size() + 1),
                           .title = group,
                           .command = page.command,
                           .status = ClaimReport::Item::Status::kDone,
                           .quick = page.quick,
                           .build = build_info(),
                           .date = date_and_time()};
    Findings& found = item.result;
    for (const ValidationRow& row : page.rows) {
      if (row.group != group) continue;
      found.claims.push_back(row.claim);
      found.claims.back().note = note_of(row);
      item.cpu_seconds += row.seconds / row.shared;
    }
    item.wall_seconds = item.cpu_seconds;
    found.figures.push_back(
        {.name = item.name,
         .caption = "Relative error of each observable against the tolerance of the steps.",
         .chart = error_chart(page, group)});
    const auto drawings = page.figures.find(group);
    if (drawings != page.figures.end()) {
      found.figures.insert(found.figures.end(), drawings->second.begin(), drawings->second.end());
    }
    found.tables.push_back(tolerances(page, group));
    complete(found, item.command);
    report.items.push_back(std::move(item));
  }
  return report;
}

void write_validation(const std::filesystem::path& folder, const ValidationPage& page) {
  const ClaimReport report = to_report(page);
  write_figures(folder, to_document(report));
  write_text_file(folder / "validate.csv", to_csv(points_table(page)));
  write_text_file(folder / "verdicts.csv", to_csv(verdicts_table(page)));
  write_report(folder, "validate.json", report);
}

}  // namespace bipot
