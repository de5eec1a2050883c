#pragma once

#include "core/problem/contact_error.h"
#include "solvers/solver.h"

namespace bipot {

/// Rounding alone may put the guarded error in double precision below the tolerance: friction
/// multiplies the rounding of the sliding velocity in û = u + mu |u_t| n, and impulses of a hyperstatic packing
/// may be large beside the energy that they move. A claim of convergence therefore is proved: the error in double
/// and the bound of its rounding (core/problem/rounding_bound.h) are within the tolerance together,
/// or else the error in extended precision (core/problem/extended_error.h) and its bound are, or in quadruple.
struct ExtendedClaim {
  bool holds = true;
  double error =
      kNaN;  ///< guarded error with its bound in the wider precision; NaN: double was enough
};

/// Judges the impulse s, whose figures `error` meet options.tol in double precision. It holds where
/// it is proved, and where another stop test is asked for. s is taken on the cone to rounding.
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
