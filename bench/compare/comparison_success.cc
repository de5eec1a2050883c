#include "bench/compare/comparison_success.h"

#include <algorithm>

#include "bench/compare/comparison_measures.h"

namespace bipot {
namespace {

constexpr SuccessCurve::SizeClass kSizeClasses[] = {
    {"up to 100 contacts", 0, 100},
    {"101 to 1000 contacts", 100, 1000},
    {"more than 1000 contacts", 1000, std::numeric_limits<int>::max()}};

constexpr double kTolerances[] = {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12};

}  // namespace

std::span<const SuccessCurve::SizeClass> size_classes() { return kSizeClasses; }

std::vector<SuccessCurve> success_curves(const Comparison& comparison) {
  // The least guarded error that a solver reached on a problem.
  std::map<std::pair<std::string, std::string>, double> least;
  double tightest = kInfinity;
  for (const Comparison::Row& row : comparison.rows) {
    tightest = std::min(tightest, row.tol);
    const auto place = least.try_emplace({row.problem, row.solver}, kInfinity).first;
    if (row.guarded < place->second) place->second = row.guarded;
  }
  std::vector<SuccessCurve> curves;
  for (const SuccessCurve::SizeClass& size : kSizeClasses) {
    for (const std::string& solver : solvers_of(comparison)) {
      SuccessCurve curve{.size = size.name, .solver = solver};
      for (const double tol : kTolerances) {
        // 1e-12 as typed and as computed may differ in the last bit.
        if (tol > 0.999 * tightest) curve.points.push_back({tol, 0});
      }
      for (const Comparison::Problem& problem : comparison.problems) {
        if (!size.has(problem.contacts)) continue;
        ++curve.problems;
        const auto reached = least.find({problem.name, solver});
        if (reached == least.end()) continue;
        for (SuccessCurve::Point& point : curve.points) {
          point.solved += reached->second <= point.tol ? 1 : 0;
        }
      }
      if (curve.problems > 0 && !curve.points.empty()) curves.push_back(std::move(curve));
    }
  }
  return curves;
}

Table success_table(const std::vector<SuccessCurve>& curves) {
  Table table{.columns = {{"size"}, {"solver"}, {"tol"}, {"problems"}, {"solved"}, {"share"}}};
  for (const SuccessCurve& curve : curves) {
    for (const SuccessCurve::Point& point : curve.points) {
      table.add(
          {curve.size, curve.solver, point.tol, curve.problems, point.solved, curve.share(point)});
    }
  }
  return table;
}

}  // namespace bipot
