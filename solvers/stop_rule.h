#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "solvers/solver.h"

namespace bipot {

// When iterates are judged and the consequences of a judgement, for SolveRun (solve_run.h).

/// An energy this many times that of the free violation (or of the start, if that has more) is
/// divergence, not convergence.
inline constexpr double kDivergenceFactor = 1e20;

/// Reference for the energies of iterates: free_energy, that of s = 0 [J]. At iteration 0 it is
/// that of a start beyond kDivergenceFactor of it, which is due to the caller and no growth.
double divergence_reference(int iteration, const ContactError& error, double free_energy);

inline constexpr int kJudgedPortion = 32;
/// The next iterate is judged when the count has grown by its root or by 1/portion, whichever is
/// more. If judging costs J iterations and the last count is unknown, intervals of sqrt(2 J k)
/// around k cost the least; J of quick iterations is 3 to 10. `roots`: number of roots.
inline int next_judged(int iteration, int portion = kJudgedPortion, int roots = 1) {
  const int root = static_cast<int>(std::sqrt(static_cast<double>(iteration)));
  return iteration + std::max({1, roots * root, iteration / portion});
}

/// A judged iterate.
struct JudgedIterate {
  struct Verdict {
    SolveStatus status = SolveStatus::kNotRun;  ///< kNotRun: go on
    std::string message;
  };
  int iteration = 0;
  ContactError error;
  double best_error = 0;      ///< guarded, up to here
  double free_energy = 0;     ///< divergence_reference()                                    [J]
  double change = kInfinity;  ///< from the one judged before, relative
  bool moving = false;        ///< a state beside s still changes: an equal s is no stall
  bool met = false;           ///< the stop test
};

/// All but the clock and the caller's stop.
JudgedIterate::Verdict stop_verdict(const SolverOptions& options, const JudgedIterate& iterate);

/// True if the impulse, of this error, is as exact as doubles allow, and that is far from the
/// tolerance: further iterations would only move its last digits. For the guarded test.
bool at_rounding_floor(const ContactProblem& problem, const SolverOptions& options,
                       const Eigen::Ref<const Vector>& s, const ContactError& error);

/// Verdict if the caller asked for the end, or the time is over.
JudgedIterate::Verdict out_of_time_verdict(const SolverOptions& options, bool cancelled, bool late,
                                           int iteration, double best_error);

}  // namespace bipot
