#pragma once

#include "core/problem/contact_problem.h"
#include "core/problem/delassus.h"

namespace bipot {

/// ‖diag(scale) W diag(scale)‖_inf, an upper bound of the largest eigenvalue. Assembles W where the
/// problem does not bring it: the cheaper bound from |H| would depend on the scene's direction.
double spectral_bound(const ContactProblem& problem, const Vector& scale);

inline constexpr int kPowerIterations = 30;
inline constexpr double kSpectralMargin = 1.05;

/// Largest eigenvalue of diag(scale) W diag(scale) by `iterations` steps of the power method from a
/// fixed pseudo-random start, positive for W != 0. An estimate from below: a user multiplies by
/// kSpectralMargin and watches for larger quotients.
double spectral_estimate(const ContactProblem& problem, const DelassusOperator& delassus,
                         const Vector& scale, int iterations = kPowerIterations);

}  // namespace bipot
