#pragma once

#include "solvers/contact_space.h"

namespace bipot {

inline constexpr int kPowerIterations = 30;
inline constexpr double kSpectralMargin = 1.05;

/// Largest eigenvalue of diag(scale) W diag(scale) by `iterations` steps of the power method. The
/// start is pseudo-random but fixed; the result is positive for W != 0. An estimate from below:
/// multiply by kSpectralMargin and watch for larger quotients.
double spectral_estimate(ContactSpace& space, const Vector& scale,
                         int iterations = kPowerIterations);

}  // namespace bipot
