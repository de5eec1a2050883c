#include "bench/compare/comparison_measures.h"

#include <algorithm>

namespace bipot {
const Comparison::Row* row_of(const Comparison& comparison, const std::string& problem,
                              const std::string& solver, double tol) {
  for (const Comparison::Row& row : comparison.rows) {
    if (row.tol == tol && row.solver == solver && row.problem == problem) return &row;
  }
  return nullptr;
}

std::vector<std::string> solvers_of(const Comparison& comparison) {
  return distinct_in_order(comparison.rows, &Comparison::Row::solver);
}

std::vector<double> tolerances_of(const Comparison& comparison) {
  std::vector<double> tols = distinct_in_order(comparison.rows, &Comparison::Row::tol);
  std::ranges::sort(tols, std::greater<>());
  return tols;
}

double Ranking::of(const Comparison::Row& row) const {
  constexpr double Comparison::Row::*kErrors[] = {
      &Comparison::Row::force_error, &Comparison::Row::velocity_error, &Comparison::Row::guarded};
  return row.*kErrors[static_cast<int>(measure)];
}

std::string_view Ranking::name() const {
  constexpr std::string_view kNames[] = {"force error", "velocity error", "guarded error"};
  return kNames[static_cast<int>(measure)];
}

Ranking ranking(const Comparison::Problem& problem, const std::vector<Comparison::Row>& rows) {
  if (problem.poor_reference()) return {Ranking::Measure::kGuarded};
  for (const Comparison::Row& row : rows) {
    if (row.problem == problem.name && std::isfinite(row.force_error)) {
      return {Ranking::Measure::kForce};
    }
  }
  return {Ranking::Measure::kVelocity};
}

std::vector<const Comparison::Row*> pareto_rows(const Comparison::Problem& problem,
                                                const std::vector<Comparison::Row>& rows) {
  const Ranking rank = ranking(problem, rows);
  std::vector<const Comparison::Row*> mine, best;
  for (const Comparison::Row& row : rows) {
    if (row.problem == problem.name && std::isfinite(row.time()) && std::isfinite(rank.of(row)) &&
        rank.of(row) < 1) {  // s = 0 has error 1: worse is not an answer
      mine.push_back(&row);
    }
  }
  for (const Comparison::Row* row : mine) {
    const bool beaten = std::ranges::any_of(mine, [&](const Comparison::Row* other) {
      const double t = other->time(), e = rank.of(*other);
      return t <= row->time() && e <= rank.of(*row) && (t < row->time() || e < rank.of(*row));
    });
    if (!beaten) best.push_back(row);
  }
  return best;
}

const Comparison::Row* fastest_to(const Comparison::Problem& problem,
                                  const std::vector<Comparison::Row>& rows, double accuracy,
                                  std::string_view solver) {
  if (problem.contacts == 0) return nullptr;  // no race
  const Ranking rank = ranking(problem, rows);
  const Comparison::Row* best = nullptr;
  for (const Comparison::Row& row : rows) {
    if (row.problem != problem.name || !(rank.of(row) <= accuracy)) continue;
    if (!solver.empty() && row.solver != solver) continue;
    if (std::isfinite(row.time()) && (best == nullptr || row.time() < best->time())) best = &row;
  }
  if (best == nullptr) return best;
  const Comparison::Row* loosest = best;
  for (const Comparison::Row& row : rows) {
    if (row.problem == problem.name && row.solver == best->solver && rank.of(row) <= accuracy &&
        row.time() <= 1.05 * best->time() && row.tol > loosest->tol) {
      loosest = &row;
    }
  }
  return loosest;
}

std::vector<PerformanceProfile> performance_profiles(const Comparison& comparison,
                                                     const CostOf& cost) {
  const auto races = [](const Comparison::Problem& problem) { return problem.contacts > 0; };
  const auto problems = static_cast<int>(std::ranges::count_if(comparison.problems, races));
  std::vector<PerformanceProfile> profiles;
  for (const std::string& solver : solvers_of(comparison)) {
    profiles.push_back({solver, {}, problems});
  }
  for (const Comparison::Problem& problem : comparison.problems) {
    if (!races(problem)) continue;
    std::vector<double> costs;
    double best = kInfinity;
    for (const PerformanceProfile& profile : profiles) {
      costs.push_back(cost(problem, profile.solver));
      if (costs.back() > 0) best = std::min(best, costs.back());
    }
    for (std::size_t i = 0; i < profiles.size(); ++i) {
      if (costs[i] > 0 && std::isfinite(costs[i])) profiles[i].ratios.push_back(costs[i] / best);
    }
  }
  for (PerformanceProfile& profile : profiles) std::ranges::sort(profile.ratios);
  return profiles;
}

CostOf time_at(const Comparison& comparison, double tol) {
  return [&comparison, tol](const Comparison::Problem& problem, const std::string& solver) {
    const Comparison::Row* row = row_of(comparison, problem.name, solver, tol);
    return row != nullptr && row->solved() ? row->time() : kNaN;
  };
}

CostOf iterations_at(const Comparison& comparison, double tol) {
  return [&comparison, tol](const Comparison::Problem& problem, const std::string& solver) {
    const Comparison::Row* row = row_of(comparison, problem.name, solver, tol);
    return row != nullptr && row->solved() ? std::max(1.0, 1.0 * row->iterations) : kNaN;
  };
}

CostOf time_to(const Comparison& comparison, double accuracy) {
  return [&comparison, accuracy](const Comparison::Problem& problem, const std::string& solver) {
    const Comparison::Row* row = fastest_to(problem, comparison.rows, accuracy, solver);
    return row != nullptr ? row->time() : kNaN;
  };
}

std::vector<SolvedCount> count_solved(const Comparison& comparison, double tol) {
  std::vector<SolvedCount> counts;
  for (PerformanceProfile& profile : performance_profiles(comparison, time_at(comparison, tol))) {
    SolvedCount& count = counts.emplace_back();
    count = {
        .solver = profile.solver, .tol = tol, .median_ratio = median(std::move(profile.ratios))};
    for (const Comparison::Row& row : comparison.rows) {
      if (row.solver != count.solver || row.tol != tol) continue;
      ++count.problems;
      count.solved += row.solved() ? 1 : 0;
      count.by_natural_map += row.natural_map <= 1e-8 ? 1 : 0;
    }
  }
  return counts;
}

std::vector<BudgetErrors> errors_within(const Comparison& comparison, double seconds) {
  std::vector<BudgetErrors> all;
  for (const std::string& solver : solvers_of(comparison)) {
    BudgetErrors& made = all.emplace_back();
    made.solver = solver;
    for (const Comparison::Problem& problem : comparison.problems) {
      if (problem.contacts == 0) continue;
      const Ranking rank = ranking(problem, comparison.rows);
      double least = 1;
      for (const Comparison::Row& row : comparison.rows) {
        if (row.problem == problem.name && row.solver == solver && row.time() <= seconds) {
          least = std::fmin(least, rank.of(row));
        }
      }
      made.errors.push_back(least);
    }
    std::ranges::sort(made.errors);
  }
  return all;
}

std::vector<ToleranceMeaning> tolerance_meaning(const Comparison& comparison) {
  std::map<std::string, Ranking> rankings;
  for (const Comparison::Problem& problem : comparison.problems) {
    const Ranking rank = ranking(problem, comparison.rows);
    if (problem.contacts > 0 && rank.measure != Ranking::Measure::kGuarded) {
      rankings[problem.name] = rank;
    }
  }
  std::vector<ToleranceMeaning> all;
  for (double tol : tolerances_of(comparison)) {
    ToleranceMeaning& made = all.emplace_back();
    made.tol = tol;
    std::vector<double> errors;
    for (const Comparison::Row& row : comparison.rows) {
      const auto rank = rankings.find(row.problem);
      if (row.tol != tol || !row.solved() || rank == rankings.end()) continue;
      const double error = rank->second.of(row);
      if (!std::isfinite(error)) continue;
      errors.push_back(error);
      if (made.rows++ == 0 || error > made.worst) {
        made.worst = error;
        made.worst_problem = row.problem;
        made.worst_solver = row.solver;
      }
    }
    std::ranges::sort(errors);
    made.median = sorted_median(errors);
    made.ninth_decile = quantile(errors, 0.9);
  }
  return all;
}

std::vector<Growth> growth(const Comparison& comparison) {
  std::vector<std::string> names;
  std::map<std::string, std::vector<const Comparison::Problem*>> series;
  for (const Comparison::Problem& problem : comparison.problems) {
    if (problem.series.empty() || problem.contacts == 0) continue;
    auto& members = series[problem.series];
    if (members.empty()) names.push_back(problem.series);
    members.push_back(&problem);
  }
  std::vector<Growth> all;
  for (const std::string& name : names) {
    if (series[name].size() < 2) continue;
    for (const std::string& solver : solvers_of(comparison)) {
      for (double tol : tolerances_of(comparison)) {
        Growth made{.series = name, .solver = solver, .tol = tol};
        std::vector<double> sizes, iterations, times;
        for (const Comparison::Problem* problem : series[name]) {
          const Comparison::Row* row = row_of(comparison, problem->name, solver, tol);
          if (row == nullptr) continue;
          const double n = problem->dofs;
          made.points.push_back({problem->name, n, row->iterations, row->time(), row->solved()});
          if (!row->solved()) continue;
          sizes.push_back(n);
          iterations.push_back(row->iterations);
          times.push_back(row->time());
        }
        made.iterations = fit_power_law(sizes, iterations);
        made.time = fit_power_law(sizes, times);
        all.push_back(std::move(made));
      }
    }
  }
  return all;
}

Regret regret_of(const Comparison& comparison, const std::string& solver, double least_time) {
  Regret regret{.solver = solver};
  for (const Comparison::Row& row : comparison.rows) {
    if (row.solver != solver || row.status == to_string(SolveStatus::kNothingToDo)) continue;
    const Comparison::Row* best = nullptr;
    for (const Comparison::Row& other : comparison.rows) {
      if (other.problem != row.problem || other.tol != row.tol || other.solver == solver) continue;
      if (!other.solved() || !(other.time() > 0)) continue;
      if (best == nullptr || other.time() < best->time()) best = &other;
    }
    if (best == nullptr) {
      regret.alone += row.solved() ? 1 : 0;
      continue;
    }
    if (best->time() < least_time) continue;
    const double ratio = row.solved() ? row.time() / best->time() : kInfinity;
    regret.failed += row.solved() ? 0 : 1;
    regret.entries.push_back({row.problem, best->solver, row.tol, row.time(), best->time(), ratio});
  }
  std::ranges::stable_sort(regret.entries, std::greater<>(), &Regret::Entry::ratio);
  std::vector<double> ratios;
  for (const Regret::Entry& entry : regret.entries) ratios.push_back(entry.ratio);
  std::ranges::reverse(ratios);
  regret.median = sorted_median(ratios);
  regret.ninth_decile = quantile(ratios, 0.9);
  regret.worst = quantile(ratios, 1);
  return regret;
}

}  // namespace bipot
