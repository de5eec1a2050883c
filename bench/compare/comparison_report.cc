#include "bench/compare/comparison_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>

#include "bench/compare/comparison_rows.h"
#include "bench/compare/comparison_several.h"
#include "bench/compare/comparison_success.h"
#include "bench/compare/warm_gain.h"
#include "bench/report/json_output.h"

namespace bipot {
namespace {

double tightest(const Comparison& comparison) {
  double tol = std::numeric_limits<double>::infinity();
  for (const ComparisonRow& row : comparison.rows) tol = std::min(tol, row.tol);
  return tol;
}

/// C converged, 0 nothing to do, I iteration limit, T time limit, S stalled, D diverged, F failure,
/// - invalid input, N not tried.
char letter(const std::string& status) {
  if (status == "converged") return 'C';
  if (status == "nothing to do") return '0';
  if (status == "iteration limit") return 'I';
  if (status == "time limit") return 'T';
  if (status == "stalled") return 'S';
  if (status == "diverged") return 'D';
  if (status == "invalid input") return '-';
  if (status == ComparisonRow::kNotTried) return 'N';
  return 'F';
}

std::string cell(const ComparisonRow& row) {
  if (row.status == "invalid input") return "-";
  if (row.status == ComparisonRow::kNotTried) return "N";
  return fmt::format("{} {} {:.0e}", letter(row.status), row.iterations, row.guarded);
}

Json regret_json(const Regret& regret) {
  Json j{{"cases", regret.entries.size()},
         {"failed", regret.failed},
         {"alone", regret.alone},
         {"median", regret.median},
         {"ninth_decile", regret.ninth_decile},
         {"worst", regret.worst}};
  j["entries"] = Json::array();
  for (const Regret::Entry& e : regret.entries) {
    j["entries"].push_back({{"problem", e.problem},
                            {"tol", e.tol},
                            {"ratio", e.ratio},
                            {"time", e.time},
                            {"best", e.best},
                            {"best_time", e.best_time}});
  }
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

Json problems_json(const Comparison& comparison) {
  Json all = Json::array();
  for (const ProblemSummary& p : comparison.problems) {
    Json row{{"name", p.name},     {"target", p.target},     {"origin", p.origin},
             {"defect", p.defect}, {"contacts", p.contacts}, {"dim", p.dim},
             {"dofs", p.dofs}};
    row["reference"] = {
        {"solver", p.reference_solver},
        {"guarded", p.reference_guarded},
        {"natural_map", p.reference_natural_map},
        {"velocity_spread", p.velocity_spread},
        {"answers", p.answers},
        {"spread",
         {{"velocity", p.spread.velocity}, {"force", p.spread.force}, {"energy", p.spread.energy}}},
        {"several_velocity_solutions", p.several_velocities()}};
    row["reference"]["attempts"] = Json::array();
    for (const ReferenceAttempt& a : p.attempts) {
      row["reference"]["attempts"].push_back({{"solver", a.solver},
                                              {"status", to_string(a.status)},
                                              {"guarded", a.guarded},
                                              {"seconds", a.seconds}});
    }
    row["ranked_by"] = ranking(p, comparison.rows).name();
    all.push_back(std::move(row));
  }
  return all;
}

Json row_json(const ComparisonRow& r) {
  Json row;
  for (const ComparisonColumn& column : comparison_columns()) {
    const std::string name(column.name), text = column.write(r);
    if (column.text) {
      row[name] = text;
    } else if (text.find_first_not_of("-0123456789") == std::string::npos) {
      row[name] = std::stol(text);
    } else {
      row[name] = std::strtod(text.c_str(), nullptr);
    }
  }
  return row;
}

Json rows_json(const Comparison& comparison) {
  Json all = Json::array();
  for (const ComparisonRow& row : comparison.rows) all.push_back(row_json(row));
  for (const ComparisonRow& row : comparison.warm_rows) all.push_back(row_json(row));
  return all;
}

Json warm_json(const Comparison& comparison) {
  Json all = Json::array();
  for (const WarmGain& gain : warm_gains(comparison)) {
    all.push_back({{"solver", gain.solver},
                   {"tol", gain.tol},
                   {"problems", gain.problems},
                   {"solved_cold", gain.solved_cold},
                   {"solved_warm", gain.solved_warm},
                   {"median_time_ratio", gain.time_ratio},
                   {"median_iterations_ratio", gain.iterations_ratio}});
  }
  return all;
}

Json solved_json(const Comparison& comparison) {
  Json all = Json::array();
  for (const SolvedCount& c : count_solved(comparison, tightest(comparison))) {
    all.push_back({{"solver", c.solver},
                   {"tol", c.tol},
                   {"problems", c.problems},
                   {"guarded", c.solved},
                   {"natural_map_1e-8", c.by_natural_map},
                   {"median_time_ratio", c.median_ratio}});
  }
  return all;
}

Json success_json(const Comparison& comparison) {
  Json all = Json::array();
  for (const SuccessCurve& curve : success_curves(comparison)) {
    for (const SuccessCurve::Point& point : curve.points) {
      all.push_back({{"size", curve.size},
                     {"solver", curve.solver},
                     {"tol", point.tol},
                     {"problems", curve.problems},
                     {"solved", point.solved},
                     {"share", curve.share(point)}});
    }
  }
  return all;
}

Json several_json(const Comparison& comparison) {
  Json all = Json::array();
  for (const SeveralShare& s : several_shares(comparison)) {
    all.push_back({{"size", s.size},
                   {"problems", s.problems},
                   {"several", s.several},
                   {"share", s.share()},
                   {"median_velocity", s.median_velocity},
                   {"largest_velocity", s.largest_velocity},
                   {"median_force", s.median_force},
                   {"largest_force", s.largest_force},
                   {"largest_energy", s.largest_energy}});
  }
  return all;
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

Json meaning_json(const Comparison& comparison) {
  Json all = Json::array();
  for (const ToleranceMeaning& m : tolerance_meaning(comparison)) {
    all.push_back({{"tol", m.tol},
                   {"rows", m.rows},
                   {"median", m.median},
                   {"ninth_decile", m.ninth_decile},
                   {"worst", m.worst},
                   {"worst_problem", m.worst_problem},
                   {"worst_solver", m.worst_solver}});
  }
  return all;
}

Json growth_json(const Comparison& comparison) {
  Json all = Json::array();
  for (const Growth& g : growth(comparison)) {
    const auto law = [](const PowerLaw& fit) {
      return Json{{"exponent", fit.exponent},
                  {"confidence_95", fit.confidence},
                  {"prefactor", fit.prefactor},
                  {"points", fit.points}};
    };
    all.push_back({{"series", g.series},
                   {"solver", g.solver},
                   {"tol", g.tol},
                   {"iterations", law(g.iterations)},
                   {"time", law(g.time)}});
  }
  return all;
}

}  // namespace

Json to_json(const Comparison& comparison, const ReportContext& context) {
  Json j{{"command", "compare"},
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
  j["problems"] = problems_json(comparison);
  j["rows"] = rows_json(comparison);
  j["solved"] = solved_json(comparison);
  j["success"] = success_json(comparison);
  j["several"] = several_json(comparison);
  if (!comparison.warm_rows.empty()) j["warm_starts"] = warm_json(comparison);
  j["profiles"] = profiles_json(comparison);
  j["errors_within"] = errors_within_json(comparison);
  j["tolerance_meaning"] = meaning_json(comparison);
  j["growth"] = growth_json(comparison);
  j["regret_of_auto"] = regret_json(regret_of(comparison, "auto"));
  j["regret_of_auto_from_1_ms"] = regret_json(regret_of(comparison, "auto", 1e-3));
  return j;
}

std::string to_csv(const Comparison& comparison) {
  std::string text = csv_header() + "\n";
  for (const ComparisonRow& row : comparison.rows) text += to_csv(row) + "\n";
  for (const ComparisonRow& row : comparison.warm_rows) text += to_csv(row) + "\n";
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
      " F failure, - not for this problem, N not tried: out of time before)\n",
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
  text += regret_line(regret_of(comparison, "auto"));
  for (const WarmGain& gain : warm_gains(comparison)) text += to_text(gain) + "\n";
  for (const ProblemSummary& p : comparison.problems) {
    if (!p.defect.empty()) {
      text += fmt::format("{}: {}\n", p.name, p.defect);
    } else if (!(p.reference_guarded <= ReferenceSolution::kTarget)) {
      text += fmt::format("{}: the reference stands at {:.1e} only ({})\n", p.name,
                          p.reference_guarded, p.reference_solver);
    }
  }
  text += several_text(comparison);
  return text;
}

}  // namespace bipot
