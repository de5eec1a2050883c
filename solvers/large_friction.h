#pragma once

#include "core/problem/contact_error.h"
#include "solvers/solver.h"

namespace bipot {

/// Two things let the guarded error in double precision be met by rounding alone: friction multiplies
/// the rounding of the sliding velocity in û = u + mu |u_t| n (from mu = 1e4 on), and impulses of a
/// hyperstatic packing may be large beside the energy that they move. There a claim of convergence
/// must hold in extended precision as well (core/problem/extended_error.h).
struct ExtendedClaim {
  bool holds = true;
  double error = kNaN;  ///< guarded error in extended precision; NaN where it was not asked for
};

/// Judges the impulse s, whose figures `error` meet options.tol in double precision. It holds where
/// neither is the case, where another stop test is asked for, and up to 1.25 tolerances: what
/// double precision cannot see. s is taken as it is, on the cone.
ExtendedClaim claim_in_extended_precision(const ContactProblem& problem,
                                          const SolverOptions& options,
                                          const Eigen::Ref<const Vector>& s,
                                          const ContactError& error);

/// Replaces s, entry by entry, by neighbouring doubles while that lowers the guarded error (the
/// larger one of both precisions), in at most ten rounds. Of an exact answer rounded to double only
/// mu times the rounding of sliding velocities is left over, and another double for one impulse may
/// cancel it. For few contacts: a round evaluates the criterion twice a row. Returns the error
/// reached; below mu = 1e4 that of s, which stays.
double cancel_rounding(const ContactProblem& problem, const SolverOptions& options,
                       ContactErrorEvaluator& evaluate, Vector& s);

}  // namespace bipot
