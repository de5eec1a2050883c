#pragma once

#include <functional>
#include <string>

#include "solvers/solve_run.h"

namespace bipot {

/// What solves the parts.
struct IslandSolver {
  /// `best`: the impulse that the attempt left; empty: none was made.
  std::function<void(SolveRun& run, const Vector& best)> run;
  /// Tried on a problem before its parts are cut out, which takes as long as a few dozen sweeps; a
  /// result without a status: not worth it here. None: empty.
  std::function<void(SolveRun& run)> attempt = {};
};

/// Runs `solver` on each part of the problem that is not coupled with the others, with what the
/// part needs: nothing where s = 0 obeys the law or the start does well enough already (checked,
/// not assumed), the closed form for one contact, exact block sweeps over a dense W for up to
/// kFewContacts, and `solver` for the others; those without friction as problems of d = 1. A
/// problem of one part, and one with another stop test than the guarded one, goes to `solver` as it
/// is. The result is to be judged on the whole.
///
/// A last part of 4000 contacts or more, nine tenths of all at least, is not cut out either:
/// `solver` goes on with the whole from where the others are settled.
///
/// Where `solver` has an attempt to make, that is made on the whole of up to 4000 contacts first:
/// what is easy is solved before anything is cut out. Not so where no part has two contacts, nor
/// from a warm start that settles more than a quarter of the contacts. Where none was made on the
/// whole, it is on parts of disks with up to 200 contacts, those of about one size as one problem:
/// a problem for each takes as long to make as to solve. Parts that it leaves good enough are not
/// solved again.
///
/// The tolerance of the parts: they are settled in the order of their size, each judged together
/// with those that are settled (ErrorShare). Why the whole then meets its tolerance:
/// data/manual/explanation/auto.md, "Sharing the tolerance".
///
/// `iterations` is the number of iterations over the whole that the work amounts to: that of each
/// part times its part of the contacts, rounded up. `options.max_iterations` holds for each part.
/// on_iteration sees the start and the iterations of the last part. Where a part fails the others
/// are solved all the same, each by the rules for a part before the last and without history; the
/// status is that of the first that failed, the message names it.
void solve_islands(SolveRun& run, const IslandSolver& solver);

/// Up to so many contacts a part is solved without the solver.
inline constexpr int kFewContacts = 8;

/// How many parts there are of which size, in a line.
std::string explain_islands(const ContactProblem& problem);

}  // namespace bipot
