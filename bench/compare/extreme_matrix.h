#pragma once

#include <string>
#include <vector>

#include "bench/compare/extreme_case.h"
#include "bench/measure/watch.h"
#include "solvers/analysis/existence.h"

namespace bipot {

struct ExtremeCell {
  /// Result of one solver at one case.
  enum class End {
    kSolved,    ///< claimed, and confirmed by the independent check
    kUnsolved,  ///< not solved, and says why
    kBeyond,  ///< not solved, and the known solution itself misses the tolerance once it is rounded
    kNone,    ///< not solved, and it is proved that no solution exists
    kRefused,   ///< the data were refused, as they must be
    kNotForIt,  ///< beyond the solver's dimension or size
    kWrong      ///< false claim, not finite, energy against theory, crash, hang
  };
  using enum End;
  /// How an end is named, shown on terminals, and coloured on pages (bench/report/document.h).
  struct Words {
    const char *name, *sign, *look;
  };
  std::string name, solver;  ///< of the case, of the solver
  End end = kWrong;
  std::string status, message;
  double guarded = kNaN;  ///< by bench/measure/independent_check.h; of runs the worst step's   [-]
  double true_error = kNaN;    ///< against known facts; NaN: there are none        [-]
  double energy_error = kNaN;  ///< energy that the contacts create, over what they move     [-]
  int iterations = 0;
  double cpu_seconds = 0;
  double time_limit = kNaN;         ///< CPU seconds that it had
  int steps_solved = 0, steps = 1;  ///< runs
};
const ExtremeCell::Words& words_of(ExtremeCell::End end);

struct ExtremeMatrix {
  struct Options {
    std::vector<std::string> solvers;
    std::string only;    ///< a case, or the beginning of its name; empty: all
    bool quick = false;  ///< without large cases
    double tol = 1e-8;
    double time_limit = 2;  ///< CPU seconds of a cell, at least its case's least_seconds
    Watch watch;
  };
  /// A case, and what is found out about it before any solve.
  struct Case : ExtremeCase {
    Existence verdict = Existence::kUndecided;
    std::string existence;  ///< in words; empty for runs
    double floor = kNaN;    ///< error of the known solution, rounded; NaN: not known
  };
  std::vector<Case> cases;
  std::vector<std::string> solvers;
  double tol = kNaN;               ///< that was asked for
  std::vector<ExtremeCell> cells;  ///< case by case, solver by solver
  bool complete = false;

  const ExtremeCell* find(const std::string& name, const std::string& solver) const;
};

/// Measures every cell in a child process (isolated_jobs.h). Throws std::invalid_argument for an
/// unknown solver and if `only` matches no case.
ExtremeMatrix measure_extremes(const ExtremeMatrix::Options& options);

/// Number of cells with this end, of one solver, or of all if `solver` is empty.
int count_cells(const ExtremeMatrix& matrix, ExtremeCell::End end, const std::string& solver = {});

/// The solvers that solved a case that auto tried and did not solve; empty if it did, or no solver
/// did.
std::vector<std::string> solved_by_others(const ExtremeMatrix& matrix, const std::string& name);

}  // namespace bipot
