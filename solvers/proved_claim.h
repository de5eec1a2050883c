#pragma once

#include "core/criterion/contact_error.h"
#include "solvers/solver.h"

namespace bipot {

/// Rounding alone may put the guarded error in double precision below the tolerance: friction
/// multiplies the rounding of the sliding velocity in û = u + mu |u_t| n, and impulses of a
/// hyperstatic packing may be large beside the energy that they move. A claim of convergence
/// therefore is proved: the error in double precision and the bound of its rounding
/// (core/criterion/rounding_bound.h) are within the tolerance together, or else the error in
/// extended precision (core/criterion/extended_error.h) and its bound are, or in quadruple where
/// the bound in extended precision is more than a thousandth of the tolerance.
struct ProvedClaim {
  bool holds = true;
  /// Guarded error with its bound in the wider precision; NaN: double was enough.
  double error = kNaN;
};

/// Judges the impulse s, whose figures `error` meet options.tol in double precision. It holds where
/// it is proved, and where another stop test is asked for. s is taken on the cone to rounding.
ProvedClaim prove_claim(const ContactProblem& problem, const SolverOptions& options,
                        const Eigen::Ref<const Vector>& s, const ContactError& error,
                        const ErrorShare& share = {});

}  // namespace bipot
