#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/compare/comparison.h"
#include "bench/report/document.h"

namespace bipot {

/// Number of problems of a size that one solver brings below a tolerance within the time limit.
struct SuccessCurve {
  /// Problems of one size; those without contacts belong to none.
  struct SizeClass {
    std::string_view name;
    int above = 0, up_to = 0;  ///< contacts
    bool has(int contacts) const { return contacts > above && contacts <= up_to; }
  };
  std::string_view size;  ///< SizeClass::name
  std::string solver;
  int problems = 0;  ///< of the size
  struct Point {
    double tol = 0;
    int solved = 0;  ///< a row of the solver, at any requested tolerance, has guarded <= tol
  };
  std::vector<Point> points;  ///< from loose to tight
  double share(const Point& point) const { return static_cast<double>(point.solved) / problems; }
};
std::span<const SuccessCurve::SizeClass> size_classes();

/// For each size with problems, and each solver. Tolerances are the powers of ten from 1e-3 to
/// 1e-12, down to the tightest of the table.
std::vector<SuccessCurve> success_curves(const Comparison& comparison);

/// A row for each size, solver and tolerance.
Table success_table(const std::vector<SuccessCurve>& curves);

}  // namespace bipot
