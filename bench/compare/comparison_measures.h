#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/compare/comparison.h"
#include "bench/measure/statistics.h"
#include "core/base/types.h"

namespace bipot {

/// Numbers computed from a comparison's table. All times are Comparison::Row::time().

/// A cold row; null without one.
const Comparison::Row* row_of(const Comparison& comparison, const std::string& problem,
                              const std::string& solver, double tol);

/// In the order of the rows.
std::vector<std::string> solvers_of(const Comparison& comparison);
/// From loose to tight.
std::vector<double> tolerances_of(const Comparison& comparison);

/// The true error by which a problem's solvers are ranked. It is the resultant force on bodies if
/// defined, else the velocity (of several exact answers, the distance to the nearest known one).
/// Without a trusted reference it is the guarded error.
struct Ranking {
  enum class Measure { kForce, kVelocity, kGuarded };
  Measure measure = Measure::kVelocity;
  double of(const Comparison::Row& row) const;
  std::string_view name() const;
};
Ranking ranking(const Comparison::Problem& problem, const std::vector<Comparison::Row>& rows);

/// Rows of a problem that no other row of it beats in both time and ranked error.
std::vector<const Comparison::Row*> pareto_rows(const Comparison::Problem& problem,
                                                const std::vector<Comparison::Row>& rows);
/// The row of least time whose ranked error is at most `accuracy`; null without one. If looser
/// tolerances of its solver reach it in nearly the same time (5 %), the loosest of them. `solver`:
/// among its rows alone, empty: among all.
const Comparison::Row* fastest_to(const Comparison::Problem& problem,
                                  const std::vector<Comparison::Row>& rows, double accuracy,
                                  std::string_view solver = {});

/// Number of problems that a solver solved at one tolerance.
struct SolvedCount {
  std::string solver;
  double tol = 0;
  int problems = 0;
  int solved = 0;           ///< guarded error <= tol
  int by_natural_map = 0;   ///< natural map <= 1e-8
  double median_ratio = 0;  ///< of its time to the best solver's, if solved; NaN without one
};
std::vector<SolvedCount> count_solved(const Comparison& comparison, double tol);

/// Performance profile of one solver (Dolan and Moré, Mathematical Programming 91, 2002): its cost
/// on each problem over the least cost of any solver there.
struct PerformanceProfile {
  std::string solver;
  std::vector<double> ratios;  ///< sorted, >= 1, of the problems that it solved
  int problems = 0;            ///< all of them
};
/// `cost` is positive, or NaN if the solver has no result.
using CostOf = std::function<double(const Comparison::Problem&, const std::string& solver)>;
std::vector<PerformanceProfile> performance_profiles(const Comparison& comparison,
                                                     const CostOf& cost);
/// Of the rows that met the tolerance.
CostOf time_at(const Comparison& comparison, double tol);
CostOf iterations_at(const Comparison& comparison, double tol);  ///< none at all count as one
/// Of the solver's cheapest row whose ranked error is at most `accuracy`.
CostOf time_to(const Comparison& comparison, double accuracy);

/// Errors that one solver reaches within a time.
struct BudgetErrors {
  std::string solver;
  /// Least ranked error of its rows within the time, for each problem with contacts; without such a
  /// row 1, the error of zero contact forces. Sorted.
  std::vector<double> errors;
};
std::vector<BudgetErrors> errors_within(const Comparison& comparison, double seconds);

/// True errors at a tolerance: of all rows that met it, on problems that are not ranked by the
/// guarded error.
struct ToleranceMeaning {
  double tol = 0;
  int rows = 0;
  double median = kNaN, ninth_decile = kNaN, worst = kNaN;
  std::string worst_problem, worst_solver;
};
/// From loose to tight.
std::vector<ToleranceMeaning> tolerance_meaning(const Comparison& comparison);

/// Cost against size, along one series of problems.
struct Growth {
  enum class Measure { kIterations, kTime };
  struct Point {
    std::string problem;
    double dofs = 0;  ///< degrees of freedom
    int iterations = 0;
    double time = 0;
    bool solved = false;
  };
  std::string series, solver;
  double tol = 0;
  std::vector<Point> points;
  PowerLaw iterations, time;  ///< fitted to the solved points
};
/// Of series with two sizes or more, by series, solver, tolerance.
std::vector<Growth> growth(const Comparison& comparison);

/// Time of one solver over the time of the fastest of the others that met the same tolerance.
struct Regret {
  struct Entry {
    std::string problem, best;
    double tol = 0, time = 0, best_time = 0;
    double ratio = 0;  ///< infinite if it missed the tolerance and another solver met it
  };
  std::string solver;
  std::vector<Entry> entries;  ///< from the largest ratio to the least
  int failed = 0;              ///< infinite ones among them
  int alone = 0;               ///< solved by nobody else: no entry
  double median = kNaN, ninth_decile = kNaN, worst = kNaN;
};
/// Over all problems that need impulses and tolerances that another solver met, in at least
/// least_time.
Regret regret_of(const Comparison& comparison, const std::string& solver, double least_time = 0);

}  // namespace bipot
