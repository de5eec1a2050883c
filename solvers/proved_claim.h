#pragma once

#include "core/criterion/contact_error.h"
#include "solvers/solver.h"

namespace bipot {

/// Rounding alone may put the guarded error in double precision below the tolerance. Friction
/// multiplies the rounding of the sliding velocity in û = u + mu |u_t| n, and impulses of a
/// hyperstatic packing may be large beside the energy that they move. Therefore a claim of
/// convergence is proved. Either the error in double precision plus the bound of its rounding
/// (core/criterion/rounding_bound.h) is within the tolerance; or the error in extended precision
/// (core/criterion/extended_error.h) plus its bound is. Quadruple precision is used if the bound in
/// extended precision is more than a thousandth of the tolerance.
struct ProvedClaim {
  bool holds = true;
  /// Guarded error plus its bound in the wider precision; NaN: double was enough.
  double error = kNaN;
};

/// Judges the impulse s, whose `error` meets options.tol in double precision. The claim holds if it
/// is proved, and always for other stop tests. s is taken to lie on the cone to rounding.
ProvedClaim prove_claim(const ContactProblem& problem, const SolverOptions& options,
                        const Eigen::Ref<const Vector>& s, const ContactError& error,
                        const ErrorShare& share = {});

}  // namespace bipot
