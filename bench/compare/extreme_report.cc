#include "bench/compare/extreme_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/report/labels.h"

namespace bipot {
namespace {

constexpr ExtremeCell::End kCounted[] = {ExtremeCell::kSolved,  ExtremeCell::kUnsolved,
                                         ExtremeCell::kBeyond,  ExtremeCell::kNone,
                                         ExtremeCell::kRefused, ExtremeCell::kWrong};

/// Cases by solvers, group by group. `cell_of` shows a cell, `case_of` the name of a case.
template <class CellOf, class CaseOf>
Table matrix_table(const ExtremeMatrix& m, const CellOf& cell_of, const CaseOf& case_of) {
  Table table{.columns = {{.name = "case"}}};
  for (const std::string& solver : m.solvers) table.columns.push_back({.name = solver});
  const std::string* group = nullptr;
  for (const ExtremeCase& c : m.cases) {
    if (group == nullptr || c.group != *group) table.add({c.group});
    group = &c.group;
    std::vector<Table::Cell> cells = {case_of(c)};
    for (const std::string& solver : m.solvers) {
      const ExtremeCell* cell = m.find(c.name, solver);
      cells.push_back(cell == nullptr ? Table::Cell() : cell_of(*cell));
    }
    table.add(std::move(cells));
  }
  return table;
}

Table counts_table(const ExtremeMatrix& m) {
  Table table{.columns = {{.name = "solver"}}};
  for (const ExtremeCell::End end : kCounted) {
    table.columns.push_back({.name = words_of(end).name, .show = count_label});
  }
  for (const std::string& solver : m.solvers) {
    std::vector<Table::Cell> cells = {solver};
    for (const ExtremeCell::End end : kCounted) cells.emplace_back(count_cells(m, end, solver));
    table.add(std::move(cells));
  }
  return table;
}

Table cases_table(const ExtremeMatrix& m) {
  Table table{.columns = {{"name"}, {"group"}, {"what"}, {"known"}, {"existence"}, {"floor"}},
              .key = "cases"};
  for (const ExtremeMatrix::Case& c : m.cases) {
    table.add({c.name, c.group, c.what, c.known, to_string(c.verdict), c.floor});
  }
  return table;
}

/// Known facts of a case, and the result of each solver.
void add_case(const ExtremeMatrix& m, const ExtremeMatrix::Case& c, Document& whole) {
  Document page;
  page.heading(c.name, c.name, 3);  // a link to it opens the fold
  page.say(c.what + ".");
  Terms terms{{{"known", c.known}}};
  if (!c.existence.empty()) terms.entries.emplace_back("proved", c.existence);
  if (!std::isnan(c.floor)) {
    terms.entries.emplace_back(
        "rounding", "the known answer, rounded to double precision, has the guarded error " +
                        error_label(c.floor));
  }
  if (const ExtremeCell* first = m.find(c.name, m.solvers.front())) {
    ExtremeCell any = *first;
    any.solver = "NAME";
    terms.entries.emplace_back("again", '`' + cell_command(m, any) + '`');
  }
  page.add(std::move(terms));
  Table table{.columns = {{.name = "solver"},
                          {.name = "end"},
                          {.name = "status"},
                          {.name = "guarded", .show = error_label},
                          {.name = "true error", .show = error_label},
                          {.name = "energy created", .show = error_label},
                          {.name = "iterations", .show = count_label},
                          {.name = "CPU time", .show = seconds_label}}};
  for (const std::string& solver : m.solvers) {
    const ExtremeCell* cell = m.find(c.name, solver);
    if (cell == nullptr) continue;
    const std::string steps =
        cell->steps > 1 ? fmt::format(" ({} of {} steps)", cell->steps_solved, cell->steps) : "";
    table.add({solver, Table::Cell(words_of(cell->end).name).as(words_of(cell->end).look),
               Table::Cell(cell->status + steps).tipped(cell->message), cell->guarded,
               cell->true_error, cell->energy_error, cell->iterations, cell->cpu_seconds},
              cell->end == ExtremeCell::kWrong ? "bad" : "");
  }
  page.add(std::move(table));
  whole.fold(c.name, std::move(page));
}

}  // namespace

std::string cell_command(const ExtremeMatrix& m, const ExtremeCell& cell) {
  return fmt::format("bipot extremes --only {} --solver {} --tol {} --time-limit {}", cell.name,
                     cell.solver, short_exponent(fmt::format("{}", m.tol)), cell.time_limit);
}

Table cells_table(const ExtremeMatrix& m) {
  Table table{
      .columns = Table::keyed({"group", "case", "solver", "end", "status", "guarded", "true_error",
                               "energy_error", "iterations", "cpu_seconds", "steps_solved", "steps",
                               "existence", "floor", "missed_by_auto", "message", "command"}),
      .key = "cells"};
  for (const ExtremeCell& cell : m.cells) {
    for (const ExtremeMatrix::Case& c : m.cases) {
      if (c.name != cell.name) continue;
      table.add({c.group, cell.name, cell.solver, words_of(cell.end).name, cell.status,
                 cell.guarded, cell.true_error, cell.energy_error, cell.iterations,
                 cell.cpu_seconds, cell.steps_solved, cell.steps, to_string(c.verdict), c.floor,
                 cell.end == ExtremeCell::kSolved && !solved_by_others(m, cell.name).empty(),
                 cell.message, cell_command(m, cell)});
    }
  }
  return table;
}

std::string to_text(const ExtremeMatrix& m) {
  Document d;
  Table matrix = matrix_table(
      m, [](const ExtremeCell& cell) { return Table::Cell(words_of(cell.end).sign); },
      [](const ExtremeCase& c) { return "  " + c.name; });
  for (Table::Column& column : matrix.columns) column.name = column.name.substr(0, 4);
  matrix.note =
      "ok solved and confirmed, -- not solved and says so, rd beyond double precision (the known "
      "answer rounded misses the tolerance), no solution exists (proved), rf data refused, !! "
      "false claim, NaN, crash, hang or energy against theory";
  d.add(std::move(matrix));
  d.add(counts_table(m));
  std::string text = to_text(d);
  for (const ExtremeCase& c : m.cases) {
    const std::vector<std::string> others = solved_by_others(m, c.name);
    if (others.empty()) continue;
    text += fmt::format("missed by auto: {}: solved by {}\n", c.name, fmt::join(others, ", "));
  }
  for (const ExtremeCell& cell : m.cells) {
    if (cell.end != ExtremeCell::kWrong) continue;
    text += fmt::format("wrong: {}: {}: {}\n", cell_command(m, cell), cell.status, cell.message);
  }
  return text;
}

std::string to_markdown(const ExtremeMatrix& m) {
  Table table{.columns = {{.name = " "}}};
  for (const std::string& solver : m.solvers) table.columns.push_back({.name = solver});
  for (std::size_t k = 0; k < m.cases.size(); ++k) {
    const std::string& group = m.cases[k].group;
    if (k > 0 && group == m.cases[k - 1].group) continue;
    std::vector<Table::Cell> cells = {group};
    for (const std::string& solver : m.solvers) {
      int solved = 0, possible = 0, wrong = 0;
      for (const ExtremeCase& c : m.cases) {
        const ExtremeCell* cell = c.group == group ? m.find(c.name, solver) : nullptr;
        if (cell == nullptr) continue;
        solved += cell->end == ExtremeCell::kSolved;
        wrong += cell->end == ExtremeCell::kWrong;
        possible += cell->end == ExtremeCell::kSolved || cell->end == ExtremeCell::kUnsolved ||
                    cell->end == ExtremeCell::kWrong;
      }
      cells.emplace_back(fmt::format("{}/{}{}", solved, possible,
                                     wrong > 0 ? fmt::format(", {} wrong", wrong) : ""));
    }
    table.add(std::move(cells));
  }
  return to_markdown(table);
}

Document extremes_page(const ExtremeMatrix& m, const Provenance& made) {
  Document page{.title = "Contact solvers at the extremes", .made = made};
  page.say(fmt::format(
      "{} cases, {} solvers, each asked for a guarded error of {} within its time limit: {} "
      "cells solved, {} not solved, {} beyond double precision, {} proved to have no solution, {} "
      "wrong (false claims, NaN, crashes, hangs, energy against theory).{}",
      m.cases.size(), m.solvers.size(), tolerance_label(m.tol),
      count_cells(m, ExtremeCell::kSolved), count_cells(m, ExtremeCell::kUnsolved),
      count_cells(m, ExtremeCell::kBeyond), count_cells(m, ExtremeCell::kNone),
      count_cells(m, ExtremeCell::kWrong),
      m.complete ? "" : " The measurement was stopped before its end."));
  const auto missed = std::ranges::count_if(
      m.cases, [&](const ExtremeCase& c) { return !solved_by_others(m, c.name).empty(); });
  page.say(fmt::format("Cases that `auto` misses and another solver solves: {}.", missed));
  Table key{.columns = {{.name = "colours"}}};
  key.columns.resize(std::size(kCounted), {.name = " "});
  key.add({Table::Cell("solved").as("good"), Table::Cell("not solved, and says why").as("weak"),
           Table::Cell("beyond double precision").as("beyond"),
           Table::Cell("no solution exists").as("none"), Table::Cell("data refused").as("grey"),
           Table::Cell("wrong").as("bad")});
  key.note =
      "The figure in a cell is the guarded error of the returned impulse in quadruple precision, "
      "by code that shares nothing with the solvers. Its status and message show when the pointer "
      "rests on it. Beyond double precision: the exact answer, known beforehand, misses the "
      "tolerance by the rounding of its own digits. Without a figure: data that are refused "
      "(grey), problems that are too large or of too many dimensions for a solver (white).";
  page.add(std::move(key));
  Table matrix = matrix_table(
      m,
      [](const ExtremeCell& cell) {
        const bool figure = std::isfinite(cell.guarded) && cell.end != ExtremeCell::kNotForIt;
        return Table::Cell(figure ? digit_label(cell.guarded) : "")
            .tipped(cell.status + ": " + cell.message)
            .as(words_of(cell.end).look);
      },
      [](const ExtremeCase& c) { return fmt::format("[{0}](#{0})", c.name); });
  if (missed > 0) matrix.columns.push_back({.name = "missed by auto, solved by"});
  for (std::size_t row = 0, k = 0; missed > 0 && row < matrix.rows.size(); ++row) {
    if (is_title(matrix, matrix.rows[row])) continue;
    matrix.rows[row].cells.emplace_back(
        fmt::format("{}", fmt::join(solved_by_others(m, m.cases[k++].name), ", ")));
  }
  page.add(std::move(matrix));
  page.add(cells_table(m));
  page.add(cases_table(m));
  page.heading("Cases");
  for (const ExtremeMatrix::Case& c : m.cases) add_case(m, c, page);
  page.heading("How this was made", "made");
  page.add(to_terms(made));
  page.say("[All cells as CSV](extremes.csv), [all numbers](extremes.json).", "small");
  return page;
}

}  // namespace bipot
