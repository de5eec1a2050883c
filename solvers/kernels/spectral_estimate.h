#pragma once

#include "core/problem/contact_problem.h"
#include "core/problem/delassus.h"

namespace bipot {

/// ‖diag(scale) W diag(scale)‖_inf, an upper bound of the largest eigenvalue. Assembles W if the
/// problem has none: the cheaper bound from |H| would depend on the orientation of the scene.
double spectral_bound(const ContactProblem& problem, const Vector& scale);

inline constexpr int kPowerIterations = 30;
inline constexpr double kSpectralMargin = 1.05;

/// Largest eigenvalue of diag(scale) W diag(scale) by `iterations` steps of the power method. The
/// start is pseudo-random but fixed; the result is positive for W != 0. An estimate from below:
/// multiply by kSpectralMargin and watch for larger quotients.
double spectral_estimate(const ContactProblem& problem, const DelassusOperator& delassus,
                         const Vector& scale, int iterations = kPowerIterations);

}  // namespace bipot
