#pragma once

#include "solvers/solve_run.h"

namespace bipot {

/// Runs the stages of plan_auto in turn until one meets the stop test; the message says which
/// stages ran, how they ended and which one succeeded. Budgets grow from round to round, so that a
/// wrong first guess costs a multiple of the best solver's time, not all of it. With the guarded
/// test, a success whose natural map is above the tolerance is carried on to a ten times smaller
/// one by the same solver, then by Newton, so that users who judge by either measure are served.
/// No stage is hidden: when all fail, the status is that of the last one and the impulse the best
/// one. `iterations` is the sum over stages, whose iterations differ much in cost.
///
/// Parts that do not couple are solved one by one (islands.h) unless options.islands is false. On
/// several processes the race has rounds of first order, and no islands.
void solve_auto(SolveRun& run);

/// The race alone. `attempted`: the impulse that attempt_race() left, whose stages are not run
/// again; or empty.
void run_race(SolveRun& run, const Vector& attempted);

/// The stages alone that are to be tried before parts are cut out: most of what is easy is solved
/// by then. A result without a status where there is none.
void attempt_race(SolveRun& run);

}  // namespace bipot
