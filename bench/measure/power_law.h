#pragma once

#include <vector>

#include "core/types.h"

namespace bipot {

/// y = prefactor x^exponent, fitted by least squares in the logarithms.
struct PowerLaw {
  double exponent = kNaN, prefactor = kNaN;
  /// Half width of the 95 % confidence interval of the exponent (Student's t with points - 2
  /// degrees of freedom); NaN with fewer than three points.
  double confidence = kNaN;
  int points = 0;
};

/// Pairs that are not finite and positive are left out; with fewer than two different x all
/// numbers are NaN.
PowerLaw fit_power_law(const std::vector<double>& x, const std::vector<double>& y);

/// t such that |T| <= t with the given probability, for Student's distribution.
double student_t(double probability, int degrees_of_freedom);

}  // namespace bipot
