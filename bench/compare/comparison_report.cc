#include "bench/compare/comparison_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/compare/comparison_rows.h"
#include "bench/compare/comparison_several.h"
#include "bench/compare/comparison_success.h"
#include "bench/compare/warm_gain.h"
#include "bench/measure/iteration_growth.h"
#include "bench/report/labels.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

double tightest(const Comparison& comparison) {
  double tol = kInfinity;
  for (const Comparison::Row& row : comparison.rows) tol = std::min(tol, row.tol);
  return tol;
}

/// C converged, 0 nothing to do, I iteration limit, T time limit, S stalled, D diverged, F failure.
char letter(const std::string& status) {
  if (status == "converged") return 'C';
  if (status == "nothing to do") return '0';
  if (status == "iteration limit") return 'I';
  if (status == "time limit") return 'T';
  if (status == "stalled") return 'S';
  if (status == "diverged") return 'D';
  return 'F';
}

/// - invalid input, N not tried, else its letter and numbers.
std::string cell(const Comparison::Row& row) {
  if (row.status == "invalid input") return "-";
  if (row.status == Comparison::Row::kNotTried) return "N";
  return fmt::format("{} {} {}", letter(row.status), row.iterations, digit_label(row.guarded));
}

Json regret_json(const Regret& regret) {
  Json j{{"cases", regret.entries.size()},
         {"failed", regret.failed},
         {"alone", regret.alone},
         {"median", regret.median},
         {"ninth_decile", regret.ninth_decile},
         {"worst", regret.worst}};
  j["entries"] = to_json(regret_table(regret));
  return j;
}

std::string regret_line(const Regret& regret) {
  if (regret.entries.empty()) return {};
  const Regret::Entry& worst = regret.entries.front();
  const auto ratio = [](double x) {
    return std::isfinite(x) ? fmt::format("{:.2f}", x) : std::string("not solved");
  };
  return fmt::format(
      "auto over the fastest other solver, {} cases: median {}, 90 % below {}, worst {} ({} at {}, "
      "{})\n",
      regret.entries.size(), ratio(regret.median), ratio(regret.ninth_decile), ratio(regret.worst),
      worst.problem, tolerance_label(worst.tol), worst.best);
}

Json to_json(const Comparison::Problem& p, const Ranking& rank) {
  const Json reference{{"solver", p.reference.solver},
                       {"guarded", p.reference.error.guarded()},
                       {"natural_map", p.reference.error.natural_map},
                       {"velocity_spread", p.reference.velocity_spread},
                       {"answers", p.answers},
                       {"spread", to_json(p.reference.spread)},
                       {"several_velocity_solutions", p.several_velocities()},
                       {"attempts", json_list(p.reference.attempts, [](const auto& attempt) {
                          return to_json(attempt);
                        })}};
  return {{"name", p.name},     {"target", p.target},     {"origin", p.origin},
          {"defect", p.defect}, {"contacts", p.contacts}, {"dim", p.dim},
          {"dofs", p.dofs},     {"reference", reference}, {"ranked_by", rank.name()}};
}

/// At the tightest tolerance.
Table solved_table(const Comparison& comparison) {
  Table table{.columns = {{"solver", "solver"},
                          {"tol"},
                          {"problems", "problems", count_label},
                          {"guarded", "solved", count_label},
                          {"natural_map_1e-8", "natural map ≤ 1e-8", count_label},
                          {"median_time_ratio", "median time / best", ratio_label}}};
  for (const SolvedCount& c : count_solved(comparison, tightest(comparison))) {
    table.add({c.solver, c.tol, c.problems, c.solved, c.by_natural_map, c.median_ratio});
  }
  return table;
}

/// Problems by solvers at the tightest tolerance.
Table matrix_table(const Comparison& comparison) {
  const double tol = tightest(comparison);
  Table table{.columns = {{.name = "problem"}}};
  for (const std::string& solver : solvers_of(comparison)) {
    table.columns.push_back({.name = solver});
  }
  for (const Comparison::Problem& p : comparison.problems) {
    std::vector<Table::Cell> cells = {p.name};
    cells.resize(table.columns.size());
    for (const Comparison::Row& row : comparison.rows) {
      if (row.problem != p.name || row.tol != tol) continue;
      for (std::size_t k = 1; k < cells.size(); ++k) {
        if (table.columns[k].name == row.solver) cells[k] = cell(row);
      }
    }
    table.add(std::move(cells));
  }
  return table;
}

Json profiles_json(const Comparison& comparison) {
  Json all = Json::array();
  const auto profile = [&](const char* name, const CostOf& cost, double at) {
    for (const PerformanceProfile& p : performance_profiles(comparison, cost)) {
      all.push_back({{"of", name},
                     {"at", at},
                     {"solver", p.solver},
                     {"problems", p.problems},
                     {"ratios", p.ratios}});
    }
  };
  for (double tol : tolerances_of(comparison)) {
    profile("time at tolerance", time_at(comparison, tol), tol);
    profile("iterations at tolerance", iterations_at(comparison, tol), tol);
  }
  for (double accuracy : kProfileAccuracies) {
    profile("time to true error", time_to(comparison, accuracy), accuracy);
  }
  return all;
}

Json errors_within_json(const Comparison& comparison) {
  Json all = Json::array();
  for (double budget : kBudgets) {
    for (const BudgetErrors& b : errors_within(comparison, budget)) {
      all.push_back({{"seconds", budget}, {"solver", b.solver}, {"errors", b.errors}});
    }
  }
  return all;
}

Json growth_json(const Growth& g) {
  return {{"series", g.series},
          {"solver", g.solver},
          {"tol", g.tol},
          {"iterations", to_json(g.iterations)},
          {"time", to_json(g.time)}};
}

}  // namespace

Table meaning_table(const Comparison& comparison) {
  Table table{
      .columns = {{"tol", "tolerance", tolerance_label},
                  {"rows", "rows", count_label},
                  {"median", "median error", error_label},
                  {"ninth_decile", "90 % below", error_label},
                  {"worst", "worst", error_label},
                  {"worst_problem", "on"},
                  {"worst_solver", "by"}},
      .note =
          "The error in the force on the worst body, or in the velocities where a problem does "
          "not know its bodies. Problems with several exact answers († above) count by the "
          "distance to the nearest, problems without a trusted reference (‡) are left out."};
  for (const ToleranceMeaning& m : tolerance_meaning(comparison)) {
    table.add({m.tol, m.rows, m.median, m.ninth_decile, m.worst, m.worst_problem, m.worst_solver});
  }
  return table;
}

Table regret_table(const Regret& regret) {
  Table table{.columns = {{"problem", "problem"},
                          {"tol", "tolerance", tolerance_label},
                          {"ratio", "ratio", ratio_label},
                          {"time", regret.solver, seconds_label},
                          {"best", "fastest other"},
                          {"best_time", "its time", seconds_label}}};
  for (const Regret::Entry& e : regret.entries) {
    table.add({e.problem, e.tol, e.ratio, e.time, e.best, e.best_time});
  }
  return table;
}

Json to_json(const Comparison& comparison, const ReportContext& context) {
  Json j = to_json(context.made);
  j["time_limit"] = context.options.time_limit;
  j["reference_time_limit"] = context.options.reference_time_limit;
  j["repeat"] = context.options.repeat;
  j["complete"] = comparison.complete;
  j["rows_kept"] = comparison.rows_kept;
  j["problems"] = json_list(comparison.problems, [&](const Comparison::Problem& p) {
    return to_json(p, ranking(p, comparison.rows));
  });
  j["rows"] = to_json(rows_table(comparison));
  j["solved"] = to_json(solved_table(comparison));
  j["success"] = to_json(success_table(success_curves(comparison)));
  j["several"] = to_json(several_shares_table(several_shares(comparison)));
  if (!comparison.warm_rows.empty()) j["warm_starts"] = to_json(warm_table(warm_gains(comparison)));
  j["profiles"] = profiles_json(comparison);
  j["errors_within"] = errors_within_json(comparison);
  j["tolerance_meaning"] = to_json(meaning_table(comparison));
  j["growth"] = json_list(growth(comparison), growth_json);
  j["regret_of_auto"] = regret_json(regret_of(comparison, "auto"));
  j["regret_of_auto_from_1_ms"] = regret_json(regret_of(comparison, "auto", 1e-3));
  return j;
}

std::string to_csv(const Comparison& comparison) { return to_csv(rows_table(comparison)); }

std::string to_text(const Comparison& comparison) {
  if (comparison.rows.empty()) return "no rows\n";
  Document d;
  d.say(
      fmt::format("tol {}: status, iterations, guarded error (C converged, 0 nothing to do, I "
                  "iteration limit, T time limit, S stalled, D diverged, F failure, - not for "
                  "this problem, N not tried: out of time before)",
                  tolerance_label(tightest(comparison))));
  d.add(matrix_table(comparison));
  d.add(solved_table(comparison));
  const std::vector<WarmGain> gains = warm_gains(comparison);
  if (!gains.empty()) d.add(warm_table(gains));
  std::string text = to_text(d) + regret_line(regret_of(comparison, "auto"));
  for (const Comparison::Problem& p : comparison.problems) {
    if (!p.defect.empty()) {
      text += fmt::format("{}: {}\n", p.name, p.defect);
    } else if (!(p.reference.error.guarded() <= ReferenceSolution::kTarget)) {
      text += fmt::format("{}: the reference stands at {} only ({})\n", p.name,
                          error_label(p.reference.error.guarded()), p.reference.solver);
    }
  }
  return text + several_text(comparison);
}

void write_report(const std::filesystem::path& folder, const Comparison& comparison,
                  const ReportContext& context, const Document& more, const Json* more_json) {
  write_text_file(folder / "comparison.csv", to_csv(comparison));
  write_text_file(folder / "success.csv", to_csv(success_table(success_curves(comparison))));
  write_text_file(folder / "several.csv", to_csv(several_problems_table(comparison)));
  Json json = to_json(comparison, context);
  if (more_json != nullptr) json.update(*more_json);
  write_json(json, (folder / "comparison.json").string());
  write_text_file(folder / "report.html", to_html(comparison_page(comparison, context, more)));
}

}  // namespace bipot
