#include "bench/experiments/stop_test_study.h"

#include <algorithm>

#include "bench/measure/statistics.h"
#include "bench/measure/true_error.h"
#include "solvers/solve.h"

namespace bipot {

std::vector<StopTestRow> study_stop_tests(const StopTestScene& scene,
                                          const ReferenceSolution& reference,
                                          const StopTestOptions& options) {
  const TrueErrorEvaluator true_error(scene.given, reference);
  std::vector<StopTestRow> rows;
  for (const SolverVariant& variant : options.solvers) {
    for (StopTest stop : {StopTest::kGuarded, StopTest::kRaw42, StopTest::kImpulse}) {
      bool out_of_reach = false;
      for (double tol : options.tols) {
        if (options.interrupted && options.interrupted()) return {};
        StopTestRow row;
        if (out_of_reach) row = rows.back();
        row.scene = scene.name;
        row.dynamic = scene.dynamic;
        row.solver = variant.label;
        row.stop = stop;
        row.tol = tol;
        if (!out_of_reach) {
          SolverOptions solver{.tol = tol,
                               .stop = stop,
                               .max_iterations = options.max_iterations,
                               .parameters = variant.parameters};
          const SolveResult result = solve(variant.solver, scene.given.problem, solver);
          row.met = is_success(result.status);
          row.iterations = result.iterations;
          row.velocity = true_error(result.s).velocity;
          out_of_reach = !row.met;
        }
        rows.push_back(row);
      }
    }
  }
  return rows;
}

Prediction predict(const std::vector<StopTestRow>& rows,
                   const std::function<bool(const StopTestRow&)>& wanted) {
  Prediction p;
  double sum = 0, squares = 0;
  int counted = 0;
  std::vector<double> slopes, tols, errors;
  const auto fit = [&] {
    if (tols.size() >= 3) slopes.push_back(fit_power_law(tols, errors).exponent);
    tols.clear();
    errors.clear();
  };
  const StopTestRow* before = nullptr;
  for (const StopTestRow& row : rows) {
    if (wanted && !wanted(row)) continue;
    if (before != nullptr &&
        (row.scene != before->scene || row.solver != before->solver || row.stop != before->stop)) {
      fit();
    }
    before = &row;
    ++p.asked;
    if (!row.met) continue;
    ++p.met;
    const double ratio = row.velocity / row.tol;
    if (!std::isfinite(ratio)) continue;
    if (ratio > 10) ++p.too_early;
    if (ratio < 0.1) ++p.too_late;
    if (!(ratio > 0)) continue;
    ++counted;
    tols.push_back(row.tol);
    errors.push_back(row.velocity);
    sum += std::log(ratio);
    squares += std::log(ratio) * std::log(ratio);
    p.smallest = std::fmin(p.smallest, ratio);
    p.largest = std::fmax(p.largest, ratio);
  }
  fit();
  p.slope = median(slopes);
  if (counted > 0) p.factor = std::exp(sum / counted);
  if (counted > 1) {
    const double mean = sum / counted;
    p.spread = std::exp(std::sqrt(std::max(0.0, squares / counted - mean * mean)));
  }
  return p;
}

}  // namespace bipot
