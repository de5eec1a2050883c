#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// The guarded error max(ε, η) of contact_error.h with velocities, projections and sums in extended
/// precision (64-bit significand). Friction multiplies the rounding of u_t: from mu = 1e4 on the
/// criterion in double precision is noise below about 1e-8. s is taken as it is, on the cone.
/// Velocities through the bodies where A is diagonal, else by W; undefined (NaN) without either.
double extended_guarded_error(const ContactProblem& problem, const Eigen::Ref<const Vector>& s);

}  // namespace bipot
