#include "bench/compare/leaderboard_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/report/labels.h"
#include "core/base/counted.h"

namespace bipot {
namespace {

constexpr double kBoardTols[] = {1e-2, 1e-4, 1e-6, 1e-8};

std::vector<const Leaderboard::Entry*> entries_of(const Leaderboard& board,
                                                  const std::string& who) {
  std::vector<const Leaderboard::Entry*> made;
  for (const Leaderboard::Entry& e : board.entries) {
    if (e.who == who) made.push_back(&e);
  }
  return made;
}

/// The median where missing values are infinite.
double median_of_all(std::vector<double> x) {
  for (double& value : x) value = std::isfinite(value) ? value : kInfinity;
  std::ranges::sort(x);
  return sorted_median(x);
}

Table solved_counts(const Leaderboard& board) {
  Table table{
      .columns = {{.key = "who", .name = "contestant"}},
      .key = "solved",
      .caption = "Solved, of " + counted(static_cast<long>(board.problems.size()), "problem"),
      .note =
          "Solved to T: max(ε, η, distance to the cone) at most T. A problem without "
          "an impulse is not solved. Times are those of the contestants. In medians a "
          "missing error or time is infinite."};
  if (std::ranges::any_of(board.who,
                          [](const std::string& who) { return who.starts_with("bipot "); })) {
    table.note += fmt::format(" Solvers of bipot were asked for {}.", tolerance_label(board.tol));
  }
  for (const double tol : kBoardTols) {
    const std::string label = tolerance_label(tol);
    table.columns.push_back({.key = "solved_" + label, .name = label, .show = count_label});
  }
  table.columns.push_back({.key = "error", .name = "median error", .show = error_label});
  table.columns.push_back({.key = "seconds", .name = "median time", .show = seconds_label});
  for (const std::string& who : board.who) {
    const auto entries = entries_of(board, who);
    std::vector<Table::Cell> cells{who};
    for (const double tol : kBoardTols) {
      cells.emplace_back(
          std::ranges::count_if(entries, [&](const auto* e) { return e->solves(tol); }));
    }
    std::vector<double> errors, seconds;
    for (const Leaderboard::Entry* e : entries) {
      errors.push_back(e->guarded);
      seconds.push_back(e->seconds);
    }
    cells.emplace_back(median_of_all(errors));
    cells.emplace_back(median_of_all(seconds));
    table.add(std::move(cells));
  }
  return table;
}

Table family_counts(const Leaderboard& board, double tol) {
  Table table{.columns = {{.key = "family", .name = "family"},
                          {.key = "problems", .name = "problems", .show = count_label}},
              .key = "families",
              .caption = fmt::format("Solved to {}, by family", tolerance_label(tol))};
  for (const std::string& who : board.who) {
    table.columns.push_back({.key = who, .name = who, .show = count_label});
  }
  std::map<std::string, int> sizes;
  for (const std::string& problem : board.problems) ++sizes[family_of(problem)];
  for (const auto& [family, size] : sizes) {
    std::vector<Table::Cell> cells{family, size};
    for (const std::string& who : board.who) {
      const auto entries = entries_of(board, who);
      cells.emplace_back(std::ranges::count_if(entries, [&, &name = family](const auto* e) {
        return family_of(e->problem) == name && e->solves(tol);
      }));
    }
    table.add(std::move(cells));
  }
  return table;
}

/// Share of the problems whose error is at most x.
Chart solved_chart(const Leaderboard& board) {
  Chart chart{.title = "Solved against tolerance",
              .x = {.label = "tolerance", .kind = Chart::Axis::Kind::kLog, .low = 1e-12, .high = 1},
              .y = {.label = "share solved", .low = 0, .high = 1}};
  for (const std::string& who : board.who) {
    std::vector<double> errors;
    for (const Leaderboard::Entry* e : entries_of(board, who)) {
      if (std::isfinite(e->guarded)) errors.push_back(std::max(e->guarded, 1e-12));
    }
    std::ranges::sort(errors);
    Chart::Series series{.name = who,
                         .style = static_cast<int>(chart.series.size()),
                         .points = {{.x = 1e-12, .marked = false}},
                         .kind = Chart::Series::Kind::kSteps};
    for (std::size_t k = 0; k < errors.size(); ++k) {
      const double share = static_cast<double>(k + 1) / static_cast<double>(board.problems.size());
      series.points.push_back({.x = errors[k], .y = share});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart time_chart(const Leaderboard& board) {
  Chart chart{.title = "Time against error",
              .x = {.label = "error", .kind = Chart::Axis::Kind::kLog},
              .y = {.label = "time", .kind = Chart::Axis::Kind::kLogSeconds}};
  for (const std::string& who : board.who) {
    Chart::Series series{.name = who,
                         .style = static_cast<int>(chart.series.size()),
                         .kind = Chart::Series::Kind::kPoints};
    for (const Leaderboard::Entry* e : entries_of(board, who)) {
      if (!std::isfinite(e->guarded) || !std::isfinite(e->seconds)) continue;
      series.points.push_back({.x = e->guarded, .y = e->seconds, .note = e->problem});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

std::string family_of(const std::string& problem) {
  const std::size_t first = std::min(problem.find('_'), problem.size());
  std::string family = problem.substr(0, problem.find_first_of("0123456789", first));
  if (family.size() < problem.size() && family.ends_with("_s")) family.pop_back();  // a step
  while (family.size() > first && family.back() == '_') family.pop_back();
  return family;
}

Table leaderboard_rows(const Leaderboard& board) {
  Table table{.columns = {{.key = "problem", .name = "problem", .filter = true},
                          {.key = "family", .name = "family", .filter = true},
                          {.key = "contacts", .name = "contacts", .show = count_label},
                          {.key = "who", .name = "contestant", .filter = true},
                          {.key = "error", .name = "error", .show = error_label},
                          {.key = "epsilon", .name = "ε", .show = error_label},
                          {.key = "eta", .name = "η", .show = error_label},
                          {.key = "cone", .name = "off the cone", .show = error_label},
                          {.key = "quadruple", .name = "in quadruple", .show = error_label},
                          {.key = "seconds", .name = "time", .show = seconds_label},
                          {.key = "defect", .name = "no verdict"}},
              .key = "rows",
              .sortable = true};
  for (const Leaderboard::Entry& e : board.entries) {
    table.add({e.problem, family_of(e.problem), e.contacts, e.who, e.guarded, e.epsilon, e.eta,
               e.cone, e.quadruple, e.seconds, e.defect});
  }
  return table;
}

Document leaderboard_document(const Leaderboard& board, const Provenance& made) {
  Document page{.title = "Leaderboard", .made = made};
  page.add(solved_counts(board));
  page.add(
      Figure{.chart = solved_chart(board), .caption = "Share of the problems that are solved"});
  page.add(Figure{.chart = time_chart(board), .caption = "Time and error of each impulse"});
  page.add(family_counts(board, 1e-6));
  return page;
}

}  // namespace bipot
