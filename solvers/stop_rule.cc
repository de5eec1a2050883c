#include "solvers/stop_rule.h"

#include <fmt/format.h>

#include <cmath>

#include "core/criterion/rounding_bound.h"

namespace bipot {

double divergence_reference(int iteration, const ContactError& error, double free_energy) {
  const bool far_off = error.energy > kDivergenceFactor * free_energy;
  return iteration == 0 && far_off && std::isfinite(error.energy) ? error.energy : free_energy;
}

JudgedIterate::Verdict stop_verdict(const SolverOptions& options, const JudgedIterate& it) {
  // Consecutive iterates that differ by less than this, relative, count as equal.
  constexpr double kRoundOff = 4 * std::numeric_limits<double>::epsilon();
  if (it.met) {
    return {SolveStatus::kConverged,
            fmt::format("{} test met after {} iterations", to_string(options.stop), it.iteration)};
  }
  if (std::isnan(it.error.guarded()) || !(it.error.energy <= kDivergenceFactor * it.free_energy)) {
    return {SolveStatus::kDiverged,
            fmt::format("the iterate grew without bound by iteration {}", it.iteration)};
  }
  if (it.change <= kRoundOff && it.iteration > 0 && !it.moving) {
    return {SolveStatus::kStalled,
            fmt::format("stalled at round-off: the iterate no longer changes at iteration {}, best "
                        "error {:.2e}",
                        it.iteration, it.best_error)};
  }
  if (it.iteration >= options.max_iterations) {
    return {SolveStatus::kIterationLimit,
            fmt::format("iteration limit {} reached, best error {:.2e}", options.max_iterations,
                        it.best_error)};
  }
  return {};
}

bool at_rounding_floor(const ContactProblem& problem, const SolverOptions& options,
                       const Eigen::Ref<const Vector>& s, const ContactError& error) {
  constexpr double kFar = 100;
  if (options.stop != StopTest::kGuarded || !(error.guarded() > options.tol)) return false;
  const double floor = rounding_floor(problem, s, error);
  return floor > kFar * options.tol && error.guarded() <= floor;
}

JudgedIterate::Verdict out_of_time_verdict(const SolverOptions& options, bool cancelled, bool late,
                                           int iteration, double best_error) {
  if (cancelled) {
    return {
        SolveStatus::kInterrupted,
        fmt::format("interrupted after {} iterations, best error {:.2e}", iteration, best_error)};
  }
  if (late) {
    return {SolveStatus::kTimeLimit,
            fmt::format("time limit {:.3g} s reached after {} iterations, best error {:.2e}",
                        options.time_limit, iteration, best_error)};
  }
  return {};
}

}  // namespace bipot
