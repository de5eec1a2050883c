#pragma once

#include "core/criterion/contact_error.h"
#include "solvers/solver.h"

namespace bipot {

/// Replaces s, entry by entry, by neighbouring doubles while that lowers the guarded error (the
/// larger one of both precisions), in at most ten rounds. Of an exact answer rounded to double only
/// mu times the rounding of sliding velocities is left over, and another double for one impulse may
/// cancel it. For few contacts: a round evaluates the criterion twice a row. Returns the error
/// reached; below mu = 1e4 that of s, which stays.
double cancel_rounding(const ContactProblem& problem, const SolverOptions& options,
                       ContactErrorEvaluator& evaluate, Vector& s);

}  // namespace bipot
