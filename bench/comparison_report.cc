#include "bench/comparison_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "bench/json_output.h"

namespace bipot {
namespace {

nlohmann::ordered_json number(double x) {
  return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json(nullptr);
}

std::vector<std::string> solvers_of(const Comparison& comparison) {
  std::vector<std::string> names;
  for (const ComparisonRow& row : comparison.rows) {
    if (std::find(names.begin(), names.end(), row.solver) == names.end()) {
      names.push_back(row.solver);
    }
  }
  return names;
}

double tightest(const Comparison& comparison) {
  double tol = std::numeric_limits<double>::infinity();
  for (const ComparisonRow& row : comparison.rows) tol = std::min(tol, row.tol);
  return tol;
}

/// C converged, 0 nothing to do, I iteration limit, T time limit, S stalled, D diverged, F failure,
/// - invalid input.
char letter(const std::string& status) {
  if (status == "converged") return 'C';
  if (status == "nothing to do") return '0';
  if (status == "iteration limit") return 'I';
  if (status == "time limit") return 'T';
  if (status == "stalled") return 'S';
  if (status == "diverged") return 'D';
  if (status == "invalid input") return '-';
  return 'F';
}

std::string cell(const ComparisonRow& row) {
  if (row.status == "invalid input") return "-";
  return fmt::format("{} {} {:.0e}", letter(row.status), row.iterations, row.guarded);
}

}  // namespace

std::string tolerance_label(double tol) {
  if (tol >= 1e-2) return fmt::format("{:g}", tol);
  std::string text = fmt::format("{:e}", tol);
  const std::size_t e = text.find('e');
  const double mantissa = std::strtod(text.substr(0, e).c_str(), nullptr);
  return fmt::format("{:g}e{}", mantissa, std::strtol(text.c_str() + e + 1, nullptr, 10));
}

double Ranking::of(const ComparisonRow& row) const {
  switch (measure) {
    case Measure::kForce:
      return row.force_error;
    case Measure::kVelocity:
      return row.velocity_error;
    case Measure::kGuarded:
      return row.guarded;
  }
  return row.guarded;
}

std::string_view Ranking::name() const {
  switch (measure) {
    case Measure::kForce:
      return "force error";
    case Measure::kVelocity:
      return "velocity error";
    case Measure::kGuarded:
      return "guarded error";
  }
  return "";
}

Ranking ranking(const ProblemSummary& problem, const std::vector<ComparisonRow>& rows) {
  if (problem.several_velocities()) return {Ranking::Measure::kGuarded};
  for (const ComparisonRow& row : rows) {
    if (row.problem == problem.name && std::isfinite(row.force_error)) {
      return {Ranking::Measure::kForce};
    }
  }
  return {Ranking::Measure::kVelocity};
}

std::vector<const ComparisonRow*> pareto_rows(const ProblemSummary& problem,
                                              const std::vector<ComparisonRow>& rows) {
  const Ranking rank = ranking(problem, rows);
  std::vector<const ComparisonRow*> mine, best;
  for (const ComparisonRow& row : rows) {
    if (row.problem == problem.name && std::isfinite(row.total_min) &&
        std::isfinite(rank.of(row)) &&
        rank.of(row) < 1) {  // s = 0 has error 1: worse is not an answer
      mine.push_back(&row);
    }
  }
  for (const ComparisonRow* row : mine) {
    const bool beaten = std::any_of(mine.begin(), mine.end(), [&](const ComparisonRow* other) {
      const double t = other->total_min, e = rank.of(*other);
      return t <= row->total_min && e <= rank.of(*row) && (t < row->total_min || e < rank.of(*row));
    });
    if (!beaten) best.push_back(row);
  }
  return best;
}

const ComparisonRow* fastest_to(const ProblemSummary& problem,
                                const std::vector<ComparisonRow>& rows, double accuracy) {
  const Ranking rank = ranking(problem, rows);
  const ComparisonRow* best = nullptr;
  for (const ComparisonRow& row : rows) {
    if (row.problem != problem.name || !(rank.of(row) <= accuracy)) continue;
    if (std::isfinite(row.total_min) && (best == nullptr || row.total_min < best->total_min)) {
      best = &row;
    }
  }
  return best;
}

std::vector<SolvedCount> count_solved(const Comparison& comparison, double tol) {
  std::vector<SolvedCount> counts;
  for (const std::string& solver : solvers_of(comparison)) {
    SolvedCount count{.solver = solver, .tol = tol};
    std::vector<double> ratios;
    for (const ComparisonRow& row : comparison.rows) {
      if (row.solver != solver || row.tol != tol) continue;
      ++count.problems;
      if (row.natural_map <= 1e-8) ++count.by_natural_map;
      if (!row.solved()) continue;
      ++count.solved;
      double best = row.total_min;
      for (const ComparisonRow& other : comparison.rows) {
        if (other.problem == row.problem && other.tol == tol && other.solved()) {
          best = std::min(best, other.total_min);
        }
      }
      if (best > 0) ratios.push_back(row.total_min / best);
    }
    std::sort(ratios.begin(), ratios.end());
    count.median_ratio =
        ratios.empty() ? std::numeric_limits<double>::quiet_NaN() : ratios[ratios.size() / 2];
    counts.push_back(count);
  }
  return counts;
}

nlohmann::ordered_json to_json(const Comparison& comparison, const ReportContext& context) {
  nlohmann::ordered_json j{{"command", "compare"},
                           {"command_line", context.command},
                           {"version", context.build.version},
                           {"commit", context.build.commit},
                           {"compiler", context.build.compiler},
                           {"flags", context.build.flags},
                           {"build_type", context.build.build_type},
                           {"cpu", context.build.cpu},
                           {"cores", context.build.cores},
                           {"threads", 1},
                           {"date", context.date},
                           {"time_limit", context.options.time_limit},
                           {"reference_time_limit", context.options.reference_time_limit},
                           {"repeat", context.options.repeat},
                           {"complete", comparison.complete},
                           {"rows_kept", comparison.rows_kept}};
  j["problems"] = nlohmann::ordered_json::array();
  for (const ProblemSummary& p : comparison.problems) {
    nlohmann::ordered_json row{{"name", p.name},     {"target", p.target},     {"origin", p.origin},
                               {"defect", p.defect}, {"contacts", p.contacts}, {"dim", p.dim},
                               {"dofs", p.dofs}};
    row["reference"] = {{"solver", p.reference_solver},
                        {"guarded", number(p.reference_guarded)},
                        {"natural_map", number(p.reference_natural_map)},
                        {"velocity_spread", number(p.velocity_spread)},
                        {"several_velocity_solutions", p.several_velocities()}};
    row["reference"]["attempts"] = nlohmann::ordered_json::array();
    for (const ReferenceAttempt& a : p.attempts) {
      row["reference"]["attempts"].push_back({{"solver", a.solver},
                                              {"status", to_string(a.status)},
                                              {"guarded", number(a.guarded)},
                                              {"seconds", a.seconds}});
    }
    row["ranked_by"] = ranking(p, comparison.rows).name();
    j["problems"].push_back(std::move(row));
  }
  j["rows"] = nlohmann::ordered_json::array();
  for (const ComparisonRow& r : comparison.rows) {
    nlohmann::ordered_json row;
    for (const Column& column : comparison_columns()) {
      const std::string name(column.name), text = column.write(r);
      if (column.text) {
        row[name] = text;
      } else if (text.find_first_not_of("-0123456789") == std::string::npos) {
        row[name] = std::stol(text);
      } else {
        row[name] = number(std::strtod(text.c_str(), nullptr));
      }
    }
    j["rows"].push_back(std::move(row));
  }
  j["solved"] = nlohmann::ordered_json::array();
  for (const SolvedCount& c : count_solved(comparison, tightest(comparison))) {
    j["solved"].push_back({{"solver", c.solver},
                           {"tol", c.tol},
                           {"problems", c.problems},
                           {"guarded", c.solved},
                           {"natural_map_1e-8", c.by_natural_map},
                           {"median_time_ratio", number(c.median_ratio)}});
  }
  return j;
}

std::string to_csv(const Comparison& comparison) {
  std::string text = csv_header() + "\n";
  for (const ComparisonRow& row : comparison.rows) text += to_csv(row) + "\n";
  return text;
}

std::string to_text(const Comparison& comparison) {
  if (comparison.rows.empty()) return "no rows\n";
  const double tol = tightest(comparison);
  const std::vector<std::string> solvers = solvers_of(comparison);
  std::size_t name_width = 7;
  for (const ProblemSummary& p : comparison.problems) {
    name_width = std::clamp(p.name.size(), name_width, std::size_t{44});
  }
  constexpr std::size_t kCell = 15;
  const std::size_t per_block = std::max<std::size_t>(1, (99 - name_width) / kCell);
  std::string text = fmt::format(
      "tol {}: status, iterations, guarded error\n"
      "(C converged, 0 nothing to do, I iteration limit, T time limit, S stalled, D diverged,\n"
      " F failure, - not for this problem)\n",
      tolerance_label(tol));
  for (std::size_t begin = 0; begin < solvers.size(); begin += per_block) {
    const std::size_t end = std::min(begin + per_block, solvers.size());
    text += fmt::format("\n{:<{}}", "problem", name_width);
    for (std::size_t s = begin; s < end; ++s) text += fmt::format(" {:>{}}", solvers[s], kCell - 1);
    text += '\n';
    for (const ProblemSummary& p : comparison.problems) {
      text += fmt::format("{:<{}}", p.name.substr(0, name_width), name_width);
      for (std::size_t s = begin; s < end; ++s) {
        std::string content;
        for (const ComparisonRow& row : comparison.rows) {
          if (row.problem == p.name && row.solver == solvers[s] && row.tol == tol) {
            content = cell(row);
          }
        }
        text += fmt::format(" {:>{}}", content, kCell - 1);
      }
      text += '\n';
    }
  }
  text += fmt::format("\n{:<16} {:>14} {:>20} {:>22}\n", "solver", "solved", "natural map <= 1e-8",
                      "median time / best");
  for (const SolvedCount& c : count_solved(comparison, tol)) {
    text +=
        fmt::format("{:<16} {:>7} of {:>3} {:>13} of {:>3} {:>22}\n", c.solver, c.solved,
                    c.problems, c.by_natural_map, c.problems,
                    std::isfinite(c.median_ratio) ? fmt::format("{:.1f}", c.median_ratio) : "-");
  }
  for (const ProblemSummary& p : comparison.problems) {
    if (!p.defect.empty()) {
      text += fmt::format("{}: {}\n", p.name, p.defect);
    } else if (!(p.reference_guarded <= ReferenceSolution::kTarget)) {
      text += fmt::format("{}: the reference stands at {:.1e} only ({})\n", p.name,
                          p.reference_guarded, p.reference_solver);
    }
    if (p.several_velocities()) {
      text += fmt::format(
          "{}: several velocity solutions, {:.1e} apart; errors against one of them say little\n",
          p.name, p.velocity_spread);
    }
  }
  return text;
}

}  // namespace bipot
