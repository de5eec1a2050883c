#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/measure/problem_target.h"
#include "bench/measure/reference_solution.h"
#include "bench/measure/watch.h"
#include "core/base/types.h"
#include "solvers/solver.h"

namespace bipot {

struct Comparison {
  /// One solver on one problem at one tolerance. Undefined numbers are NaN.
  struct Row {
    std::string problem, solver;
    double tol = kNaN;
    int warm = 0;  ///< 1: started from the problem's start, 0: from s = 0
    int contacts = 0, dim = 0;
    std::string status = "not run", message;
    int iterations = 0;
    int repeats = 0;  ///< solves behind the times
    double setup_min = kNaN, setup_median = kNaN, solve_min = kNaN,
           solve_median = kNaN;  ///< wall [s]
    double total_min = kNaN;     ///< least set-up + solve of one repeat, wall          [s]
    double cpu_min = kNaN;       ///< least CPU time of one repeat in all           [s]
    double epsilon = kNaN, eta = kNaN, guarded = kNaN, raw42 = kNaN, natural_map = kNaN;
    int take_off = 0, stick = 0, slip = 0;
    /// TrueError's fields, against the nearest known answer of the problem.
    double velocity_error = kNaN, force_error = kNaN, contact_force_error = kNaN;
    double penetration_velocity = kNaN, penetration = kNaN, dissipated = kNaN, energy_error = kNaN;
    int answer = 0;      ///< that answer: 1 the reference, 2, 3, ... others; 0: none is known
    std::string commit;  ///< of the program that made the row

    bool solved() const { return guarded <= tol; }
    /// Time that reports compare: CPU time. Waiting for a core does not count, and all solvers run
    /// on one.
    double time() const { return cpu_min; }
    static constexpr const char* kNotTried = "not tried";  ///< a status: see Options
  };
  /// The guarded error along one solve, at judged iterations (solvers/solve_run.h), thinned to
  /// steps of a tenth beyond the 32nd. Of all tolerances of a solver the tightest that was run.
  struct History {
    struct Point {
      int iteration = 0;
      double seconds = 0;  ///< wall time since the solver began
      double epsilon = kNaN, eta = kNaN;
      double guarded() const;  ///< max(epsilon, eta)
    };
    std::string problem, solver;
    double tol = kNaN;
    std::vector<Point> points;
  };
  /// Summary of a problem.
  struct Problem {
    std::string name, target, origin;
    /// Reason why there is no problem: the file is not readable, the run failed.
    std::string defect;
    std::string series;  ///< see ProblemSource
    int contacts = 0, dim = 0, dofs = 0;
    ReferenceSolution reference;  ///< without impulses
    /// Number of known distinct exact answers, of attempts and rows alike; 0: no reference below
    /// 1e-9. More than one proves that there are several (solvers/analysis/distinct_answers.h).
    int answers = 0;

    bool several_velocities() const { return answers > 1; }
    /// Errors against it are no true errors.
    bool poor_reference() const { return reference.error.guarded() > ReferenceSolution::kTrusted; }
  };
  struct Options {
    std::vector<std::string> solvers;
    /// Solvers beside those of the table, after them; names of their own. The strings behind `name`
    /// must live.
    std::vector<SolverEntry> foreign;
    std::vector<double> tols = {1e-2, 1e-4, 1e-6, 1e-8};
    double time_limit = 2;            ///< CPU seconds of one solve
    double reference_time_limit = 5;  ///< of one attempt at a reference
    int repeat = 1;                   ///< solves behind each time, at least
    int threads = 1;                  ///< of each solve; CPU seconds are those of all of them
    double min_time = 0.02;  ///< a short solve is repeated until its repeats took this long [s]
    /// True: run a solver even after it ran out of time on a smaller problem of the series, at the
    /// same tolerance or a looser one, or on the same problem at a looser one. Else these rows have
    /// the status "not tried". `auto` always runs.
    bool try_all = false;
    bool warm = false;  ///< each row once more from the problem's start, if it has one
    /// rows.csv, history.csv, references/, problems/; empty: nothing is written.
    std::filesystem::path out;
    std::function<void(const Row&, int done, int total)> on_row;
    Watch watch;  ///< a row that an interruption cuts short is left out
  };
  std::vector<Problem> problems;   ///< in the order of the sources
  std::vector<Row> rows;           ///< problem by problem, solver by solver, loose to tight
  std::vector<History> histories;  ///< in the same order
  /// With Options::warm, in the order of `rows`, which are cold: what is ranked.
  std::vector<Row> warm_rows;
  int rows_kept = 0;  ///< of an earlier, stopped comparison
  bool complete = false;

  /// The problem's part of the report: its id, and a link to it.
  std::string id_of(const Problem& problem) const;
  std::string link_to(const Problem& problem) const;
};

/// Fills the table. Rows are appended to out/rows.csv as they finish; existing rows there (same
/// problem, solver, tolerance and start) are kept. A solver that reached the time limit, and whose
/// iterates do not depend on the tolerance, is not run again at tighter ones: those rows repeat the
/// values and say so. If rows of a problem find further exact answers, the errors of its rows are
/// measured again against the nearest. (Rows kept from a comparison that was stopped within the
/// problem are excepted.) Throws FileError, and std::invalid_argument for an unknown solver, one
/// that is named twice, or an `out` whose rows were made under other limits.
Comparison compare(const std::vector<ProblemSource>& sources, const Comparison::Options& options);

}  // namespace bipot
