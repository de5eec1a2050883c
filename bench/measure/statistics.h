#pragma once

#include <algorithm>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// The values of a member, or of a function, that a list has, each once, in the order of the list.
template <class List, class Of>
auto distinct_in_order(const List& list, Of of) {
  std::vector<std::decay_t<std::invoke_result_t<Of, decltype(*list.begin())>>> values;
  for (const auto& item : list) {
    const auto& value = std::invoke(of, item);
    if (std::ranges::find(values, value) == values.end()) values.push_back(value);
  }
  return values;
}

/// Slope of the straight line through points by least squares.
double fitted_slope(std::span<const double> x, std::span<const double> y);

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
/// The exponent with its confidence if there is one, "1.04 ± 0.03"; a dash without an exponent.
std::string exponent_label(const PowerLaw& law);

/// t such that |T| <= t with the given probability, for Student's distribution.
double student_t(double probability, int degrees_of_freedom);

/// The median. Values that are not finite are left out; NaN if none remain.
double median(std::vector<double> x);

/// The median of sorted values, of which infinite ones count; NaN without any.
double sorted_median(std::span<const double> sorted);

/// The value that a fraction `q` of the sorted values does not exceed: the nearest rank. NaN without
/// any.
double quantile(std::span<const double> sorted, double q);

/// Mean of independent measurements.
struct MeanValue {
  double mean = kNaN;
  /// Half width of the 95 % confidence interval (Student's t); NaN below two.
  double confidence = kNaN;
};
MeanValue mean_value(std::span<const double> x);
/// That of the means of blocks of a long series. Empty blocks do not count.
MeanValue mean_of_blocks(std::span<const std::vector<double>> blocks);

/// P(x) ~ exp(-rate x) for x >= from, by maximum likelihood: rate = 1 / mean(x - from).
struct ExponentialTail {
  double rate = kNaN;
  /// Half width of the 95 % confidence interval for independent x: 1.96 rate / sqrt(points).
  double confidence = kNaN;
  /// Kolmogorov's distance between the tail and the fit: largest difference of distributions.
  double distance = kNaN;
  int points = 0;
};
ExponentialTail fit_exponential_tail(std::vector<double> x, double from);

}  // namespace bipot
