#include "bench/measure/limited_solve.h"

#include "bench/measure/stopwatch.h"
#include "solvers/solve.h"

namespace bipot {

SolveResult solve_within(const SolverEntry& entry, const ContactProblem& problem,
                         SolverOptions options, double seconds) {
  CpuLimit limit(seconds);
  options.time_limit = CpuLimit::kWallFactor * seconds;
  options.cancelled = [&, cancelled = std::move(options.cancelled)] {
    return limit() || (cancelled && cancelled());
  };
  SolveResult r = solve(entry, problem, options);
  if (limit.reached() && !is_success(r.status)) r.status = SolveStatus::kTimeLimit;
  return r;
}

StepSolution taken_step(const SolveResult& result) {
  return {.converged = is_success(result.status),
          .refused = result.status == SolveStatus::kInvalidInput,
          .message = result.message,
          .s = result.s,
          .error = result.error};
}

CpuLimit::CpuLimit(double seconds)
    : end_(cpu_seconds() + seconds),
      grain_(std::min(1e-3, seconds / 20)),
      asked_(Clock::now()),
      read_(asked_) {}

bool CpuLimit::operator()() {
  // Iterations may take a microsecond or a second, in any order. A few quick calls pass unchecked.
  // Then the wall clock, which is cheap to read, decides whether to ask the system for the CPU
  // time.
  if (reached_ || ++calls_ < stride_) return reached_;
  calls_ = 0;
  const Clock::time_point now = Clock::now();
  const auto since = [now](Clock::time_point then) {
    return std::chrono::duration<double>(now - then).count();
  };
  stride_ = since(asked_) < grain_ ? 8 : 1;
  asked_ = now;
  if (since(read_) < grain_) return false;
  read_ = now;
  reached_ = cpu_seconds() >= end_;
  return reached_;
}

void warm_up(const SolverEntry& entry) {
  ContactProblem p{.dim = 2};
  p.W.resize(2, 2);
  p.W.setIdentity();
  p.W.makeCompressed();
  p.u_free = Vector(Eigen::Vector2d(-1, 0.5));
  p.mu = Vector::Constant(1, 0.3);
  solve(entry, p, {.tol = 1e-10, .time_limit = 1});
}

}  // namespace bipot
