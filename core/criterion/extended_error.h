#pragma once

#include "core/criterion/contact_error.h"

namespace bipot {

/// The guarded error max(ε, η) of contact_error.h with projections, velocities and sums in extended
/// precision (64-bit significand). Its rounding is 2^-11 of that in double precision
/// (rounding_bound.h). Velocities go through the bodies if A is diagonal, else by W; without either
/// the error is NaN. The same bits for any number of threads.
double extended_guarded_error(const ContactProblem& problem, const Eigen::Ref<const Vector>& s,
                              const ErrorShare& share = {}, int threads = 1);

/// The same in quadruple precision (113-bit significand), in software and hence slow.
double quadruple_guarded_error(const ContactProblem& problem, const Eigen::Ref<const Vector>& s,
                               const ErrorShare& share = {}, int threads = 1);

/// The guarded error of s, whose `error` in double precision is given. Where rounding may hide as much
/// as that figure (rounding_bound.h), it is taken in extended, then in quadruple precision.
double accurate_guarded_error(const ContactProblem& problem, const Eigen::Ref<const Vector>& s,
                              const ContactError& error);

}  // namespace bipot
