#pragma once

#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/problem/delassus.h"
#include "solvers/solver.h"

namespace bipot {

/// One stage of the race that `auto` runs, and why it stands there. A stage ends when it meets the
/// stop test, at `max_iterations`, or as soon as it does not promise to get there: from
/// `min_iterations` on, the decades that the best error fell over the second half of the stage are
/// carried forward, and the stage is given up when they would not reach the tolerance within
/// `max_iterations`, unless the error is within a decade of it and `close_iterations` are not yet
/// done. A stage is passed over where the tolerance is below `least_tol` or not below `tol_below`,
/// or the best error so far above `largest_error`.
struct AutoStage {
  /// Where a stage starts: at the impulse that the same solver left at its last stage (the caller's
  /// start, the first time), at the caller's start, at the impulse of the last stage, or at the best
  /// one of all stages. The best impulse of another solver may lie where this one never gets away
  /// from (free pyramids).
  enum class Start { kOwn, kCaller, kLast, kBest };
  static constexpr int kUnlimited = std::numeric_limits<int>::max();

  std::string_view solver;
  int min_iterations = 0, max_iterations = 0;  ///< of this stage, by the solver's own count
  Start start = Start::kOwn;
  double of_start = 1;  ///< what that impulse is multiplied by
  std::map<std::string, std::string> parameters;
  std::string_view reason;
  double least_tol = 0, tol_below = kInfinity, largest_error = kInfinity;
  int close_iterations = kUnlimited;
  /// Tried on a problem before its parts are cut out, or on several of them at once
  /// (SolverEntry::attempt).
  bool before_cutting = false;
  /// Not tried again on those parts.
  bool on_whole_only = false;

  /// Whether it is run to this tolerance, with a best error so far.
  bool serves(double tol, double best_error) const {
    return tol >= least_tol && tol < tol_below && best_error <= largest_error;
  }
};

/// What few contacts begin with, before there is a plan: `anderson`, or `assor` where they are
/// those of disks, fill vectors and are not a square lattice's.
AutoStage first_of_few(const ContactProblem& problem, const DelassusOperator& delassus);
/// Up to so many contacts are few.
inline constexpr int kFewContactsOfAuto = 100;

/// The race for this problem, from its size, form and masses:
///
///   1. `assor`, the quickest on what is easy and soon seen not to be elsewhere; `anderson` on
///      small square lattices and a handful of contacts, without disks or friction, and above 2500
///      contacts from a warm start to tight tolerances (very unequal masses: `ipm` before it; up to
///      2500 contacts of disks, and where few are all there is, a path from where that ended; up to
///      400 contacts `pgs` after it, or `anderson` from a cold start where `assor` was first);
///   2. `apgd`: all that a loose tolerance needs, and a start for what follows; in its place, for
///      disks with more than 4000 contacts (8000 from a warm start), `assor`, which needs O(N^1/4)
///      iterations on packings at rest where momentum needs O(N^1/2). Above 4000 contacts
///      in the plane and at loose tolerances briefly, then `admm`: moving packings there meet 1e-2
///      by 500 solves with factors of W, where momentum needs tens of thousands of steps, and 1e-3
///      by 2000 to 5000;
///   3. d <= 2: `homotopy` from the best impulse. Moving packings, in which many contacts close
///      and slip at once, are solved exactly within a few hundred pivots. Whether a path of one
///      start arrives is chance: where it has not within two or four pivots a contact, others
///      follow, from a little off where it came nearest, and from what first order, sweeps and
///      splitting make of multiples of the caller's start. (Free pyramids have none of it: their
///      paths are long.) Above 2500 contacts `admm` comes before the first; above 4000, at
///      tolerances from 5e-4 on, `admm` from such starts comes before all long paths, with short ones
///      after each up to 12 000;
///   4. `pgs`, `ipm`, `newton`; above 4000 contacts `admm` and `ipm`, and before the paths (but for a
///      short one, up to 8000 contacts of disks, from 600 to 800 iterations of `admm`);
///      In space ipm gets 90 of its iterations at least, and before long runs come admm and 350
///      more of ipm: what a plate presses on spheres needs;
///   5. the same with patience, the cheap ones first, above 2500 contacts with `assor` of many
///      sweeps;
///      where the error is below 1e-4, chains of starts of `homotopy` from the caller's; then long
///      runs from the best impulse.
///
/// Problems given by W alone have `newton` early, up to 1000 contacts in the plane a path before it, up
/// to 100 in space `ipm` in its place, and no short `apgd`. The budgets count iterations,
/// not seconds, so that the result does not depend on the machine. The rule was taken from
/// measurements. `delassus` is the problem's; `warm`: the caller's start is not 0.
std::vector<AutoStage> plan_auto(const ContactProblem& problem, const DelassusOperator& delassus,
                                 bool warm);

/// The plan in words, one line a stage.
std::string explain_auto(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
