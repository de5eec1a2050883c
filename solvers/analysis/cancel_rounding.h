#pragma once

#include "core/criterion/contact_error.h"
#include "solvers/solver.h"

namespace bipot {

/// Replaces s, entry by entry, by neighbouring doubles while that lowers the guarded error (the
/// larger one of both precisions), in at most ten rounds. The error of an exact answer rounded to
/// double is mu times the rounding of sliding velocities; another double for one impulse may cancel
/// it. For few contacts: a round evaluates the criterion twice for each row. Returns the error
/// reached. Below mu = 1e4 s is unchanged.
double cancel_rounding(const ContactProblem& problem, const SolverOptions& options,
                       ContactErrorEvaluator& evaluate, Vector& s);

}  // namespace bipot
