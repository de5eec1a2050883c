#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "solvers/solver.h"

namespace bipot {

// When iterates are judged and the consequences of a judgement, for SolveRun (solve_run.h).

/// An energy this many times that of the free violation (of the start, should that have more) is
/// divergence, not convergence.
inline constexpr double kDivergenceFactor = 1e20;

/// What the energies of iterates are held against: free_energy, that of s = 0 [J]; at iteration 0
/// that of a start that is beyond kDivergenceFactor of it, which is the caller's and no growth.
double divergence_reference(int iteration, const ContactError& error, double free_energy);

inline constexpr int kJudgedPortion = 32;
/// One iterate is judged whenever the count has grown by its root or by 1/portion, whichever is
/// more: where judging costs J iterations and the count of the last one is not known, intervals of
/// sqrt(2 J k) around k cost the least, J of quick iterations is 3 to 10. `roots`: so many of the
/// count instead of one.
inline int next_judged(int iteration, int portion = kJudgedPortion, int roots = 1) {
  const int root = static_cast<int>(std::sqrt(static_cast<double>(iteration)));
  return iteration + std::max({1, roots * root, iteration / portion});
}

/// A judged iterate.
struct JudgedIterate {
  int iteration = 0;
  ContactError error;
  double best_error = 0;   ///< guarded, up to here
  double free_energy = 0;  ///< divergence_reference()                                    [J]
  double change =
      std::numeric_limits<double>::infinity();  ///< from the one judged before, relative
  bool moving = false;  ///< a state beside s still changes: an equal s is no stall
  bool met = false;     ///< the stop test
};

struct StopVerdict {
  SolveStatus status = SolveStatus::kNotRun;  ///< kNotRun: go on
  std::string message;
};

/// All but the clock and the caller's wish to stop.
StopVerdict stop_verdict(const SolverOptions& options, const JudgedIterate& iterate);

/// Where the caller asked for the end, or the time is over.
StopVerdict out_of_time_verdict(const SolverOptions& options, bool cancelled, bool late,
                                int iteration, double best_error);

}  // namespace bipot
