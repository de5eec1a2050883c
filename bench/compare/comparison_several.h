#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bench/compare/comparison.h"
#include "bench/report/document.h"

namespace bipot {

/// Number of problems of a size with several exact answers, and the distances of these.
struct SeveralShare {
  std::string_view size;  ///< SuccessCurve::SizeClass::name, or "all"
  int problems = 0;       ///< with contacts and a reference below 1e-9
  int several = 0;        ///< of them, those with two or more known exact answers
  /// Over those: NaN without one.
  double median_velocity = kNaN, largest_velocity = kNaN;
  double median_force = kNaN, largest_force = kNaN;
  double largest_energy = kNaN;
  double share() const { return static_cast<double>(several) / problems; }
};
/// For each size that has problems with a reference, then for all of them together.
std::vector<SeveralShare> several_shares(const Comparison& comparison);

/// The same as a table.
Table several_shares_table(const std::vector<SeveralShare>& shares);
/// The problems with several answers: a line of several.csv each.
Table several_problems_table(const Comparison& comparison);
/// "2d_x: 3 exact answers, velocities up to 5.1e-02 apart, ..." and the number of problems with
/// several.
std::string several_text(const Comparison& comparison);

}  // namespace bipot
