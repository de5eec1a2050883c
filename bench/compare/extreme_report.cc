#include "bench/compare/extreme_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "bench/report/build_info.h"
#include "bench/report/csv_text.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

std::string_view sign_of(CellEnd end) {
  switch (end) {
    case CellEnd::kSolved:
      return "ok";
    case CellEnd::kUnsolved:
      return "--";
    case CellEnd::kBeyond:
      return "rd";
    case CellEnd::kNone:
      return "no";
    case CellEnd::kRefused:
      return "rf";
    case CellEnd::kNotForIt:
      return "  ";
    default:
      return "!!";
  }
}

std::vector<std::string> groups_of(const ExtremeMatrix& m) {
  std::vector<std::string> groups;
  for (const ExtremeCase& c : m.cases) {
    if (groups.empty() || groups.back() != c.group) groups.push_back(c.group);
  }
  return groups;
}

}  // namespace

std::string cell_command(const ExtremeCell& cell) {
  return fmt::format("bipot extremes --only {} --solver {} --time-limit {:g}", cell.name,
                     cell.solver, cell.time_limit);
}

std::string to_csv(const ExtremeMatrix& m) {
  std::string text =
      "group,case,solver,end,status,guarded,true_error,energy_error,iterations,cpu_seconds,"
      "steps_solved,steps,existence,floor,missed_by_auto,message,command\n";
  for (const ExtremeCell& cell : m.cells) {
    for (std::size_t k = 0; k < m.cases.size(); ++k) {
      if (m.cases[k].name != cell.name) continue;
      text += fmt::format(
          "{},{},{},{},{},{:.3e},{:.3e},{:.3e},{},{:.4f},{},{},{},{:.3e},{},{},{}\n",
          csv_text(m.cases[k].group), cell.name, cell.solver, to_string(cell.end),
          csv_text(cell.status), cell.guarded, cell.true_error, cell.energy_error, cell.iterations,
          cell.cpu_seconds, cell.steps_solved, cell.steps, csv_text(to_string(m.verdicts[k])),
          m.floors[k], cell.end == CellEnd::kSolved && !solved_by_others(m, cell.name).empty(),
          csv_text(cell.message), csv_text(cell_command(cell)));
    }
  }
  return text;
}

std::string to_text(const ExtremeMatrix& m) {
  std::string text;
  std::string group;
  for (const ExtremeCase& c : m.cases) {
    if (c.group != group) {
      group = c.group;
      text += fmt::format("{:<26}", group);
      for (const std::string& solver : m.solvers) text += fmt::format(" {:>4.4}", solver);
      text += "\n";
    }
    text += fmt::format("  {:<24}", c.name);
    for (const std::string& solver : m.solvers) {
      const ExtremeCell* cell = m.find(c.name, solver);
      text += fmt::format(" {:>4}", cell == nullptr ? "" : sign_of(cell->end));
    }
    text += "\n";
  }
  text +=
      "ok solved and confirmed, -- not solved and says so, rd beyond double precision (the known "
      "answer rounded misses the\ntolerance), no solution exists (proved), rf data refused, !! "
      "false claim, NaN, crash, hang or energy against theory\n\n";
  text += fmt::format("{:<12} {:>7} {:>11} {:>14} {:>12} {:>8} {:>6}\n", "solver", "solved",
                      "not solved", "beyond double", "no solution", "refused", "wrong");
  for (const std::string& solver : m.solvers) {
    const CellCounts k = count_cells(m, solver);
    text += fmt::format("{:<12} {:>7} {:>11} {:>14} {:>12} {:>8} {:>6}\n", solver, k.solved,
                        k.unsolved, k.beyond, k.none, k.refused, k.wrong);
  }
  for (const ExtremeCase& c : m.cases) {
    const std::vector<std::string> others = solved_by_others(m, c.name);
    if (others.empty()) continue;
    text += fmt::format("missed by auto: {}: solved by {}\n", c.name, fmt::join(others, ", "));
  }
  for (const ExtremeCell& cell : m.cells) {
    if (cell.end != CellEnd::kWrong) continue;
    text += fmt::format("wrong: {}: {}: {}\n", cell_command(cell), cell.status, cell.message);
  }
  return text;
}

std::string to_markdown(const ExtremeMatrix& m) {
  std::string text = "| |";
  for (const std::string& solver : m.solvers) text += fmt::format(" {} |", solver);
  text += "\n| --- |";
  for (std::size_t k = 0; k < m.solvers.size(); ++k) text += " --- |";
  text += "\n";
  for (const std::string& group : groups_of(m)) {
    text += fmt::format("| {} |", group);
    for (const std::string& solver : m.solvers) {
      int solved = 0, possible = 0, wrong = 0;
      for (const ExtremeCase& c : m.cases) {
        const ExtremeCell* cell = c.group == group ? m.find(c.name, solver) : nullptr;
        if (cell == nullptr) continue;
        solved += cell->end == CellEnd::kSolved;
        wrong += cell->end == CellEnd::kWrong;
        possible += cell->end == CellEnd::kSolved || cell->end == CellEnd::kUnsolved ||
                    cell->end == CellEnd::kWrong;
      }
      text += fmt::format(" {}/{}{} |", solved, possible,
                          wrong > 0 ? fmt::format(", {} wrong", wrong) : "");
    }
    text += "\n";
  }
  return text;
}

}  // namespace bipot
