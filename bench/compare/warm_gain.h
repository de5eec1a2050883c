#pragma once

#include <string>
#include <vector>

#include "bench/compare/comparison.h"
#include "bench/report/document.h"

namespace bipot {

/// Gain of a solver at one tolerance by starting from the previous step.
struct WarmGain {
  std::string solver;
  double tol = 0;
  int problems = 0;                      ///< that have a start
  int solved_cold = 0, solved_warm = 0;  ///< of these
  double time_ratio = kNaN;              ///< warm over cold, median where both solved; NaN: none
  double iterations_ratio = kNaN;        ///< likewise, where the cold start took iterations
};
/// In the order of the warm rows; empty without any.
std::vector<WarmGain> warm_gains(const Comparison& comparison);

Table warm_table(const std::vector<WarmGain>& gains);

}  // namespace bipot
