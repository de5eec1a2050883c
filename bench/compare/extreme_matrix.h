#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/compare/extreme_case.h"
#include "solvers/analysis/existence.h"

namespace bipot {

/// Result of one solver at one case.
enum class CellEnd {
  kSolved,    ///< claimed, and confirmed by the independent check
  kUnsolved,  ///< not solved, and says why
  kBeyond,    ///< not solved, and the known solution itself misses the tolerance once it is rounded
  kNone,      ///< not solved, and it is proved that no solution exists
  kRefused,   ///< the data were refused, as they must be
  kNotForIt,  ///< beyond the solver's dimension or size
  kWrong      ///< false claim, not finite, energy against theory, crash, hang
};
/// How an end is named, shown on terminals, and coloured on pages (bench/report/document.h).
struct EndWords {
  const char *name, *sign, *look;
};
const EndWords& words_of(CellEnd end);

struct ExtremeCell {
  std::string name, solver;  ///< of the case, of the solver
  CellEnd end = CellEnd::kWrong;
  std::string status, message;
  double guarded = kNaN;  ///< by bench/measure/independent_check.h; of runs the worst step's   [-]
  double true_error = kNaN;    ///< against known facts; NaN: there are none        [-]
  double energy_error = kNaN;  ///< energy that the contacts create, over what they move     [-]
  int iterations = 0;
  double cpu_seconds = 0;
  double time_limit = kNaN;         ///< CPU seconds that it had
  int steps_solved = 0, steps = 1;  ///< runs
};

struct ExtremeMatrix {
  std::vector<ExtremeCase> cases;
  std::vector<std::string> solvers;
  std::vector<ExtremeCell> cells;      ///< case by case, solver by solver
  std::vector<std::string> existence;  ///< of each case, in words; empty for runs
  std::vector<Existence> verdicts;     ///< likewise
  std::vector<double> floors;          ///< error of the known solution, rounded; NaN: not known
  bool complete = false;

  const ExtremeCell* find(const std::string& name, const std::string& solver) const;
};

struct MatrixOptions {
  std::vector<std::string> solvers;
  std::string only;    ///< a case, or the beginning of its name; empty: all
  bool quick = false;  ///< without large cases
  double tol = 1e-8;
  double time_limit = 2;  ///< CPU seconds of a cell, at least its case's least_seconds
  std::function<void(const ExtremeCell&, int done, int total)> on_cell;
  std::function<bool()> interrupted;
};

/// Measures every cell in a child process (isolated_jobs.h). Throws std::invalid_argument for an
/// unknown solver and if `only` matches no case.
ExtremeMatrix measure_extremes(const MatrixOptions& options);

/// Number of cells with this end, of one solver, or of all if `solver` is empty.
int count_cells(const ExtremeMatrix& matrix, CellEnd end, const std::string& solver = {});

/// The solvers that solved a case that `missed` tried and did not solve; empty if it did, or no
/// solver did.
std::vector<std::string> solved_by_others(const ExtremeMatrix& matrix, const std::string& name,
                                          const std::string& missed = "auto");

}  // namespace bipot
