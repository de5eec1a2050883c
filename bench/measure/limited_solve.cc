#include "bench/measure/limited_solve.h"

#include "bench/measure/cpu_limit.h"
#include "solvers/solve.h"

namespace bipot {

SolveResult solve_within(const std::string& solver, const ContactProblem& problem, double tol,
                         double seconds, const Vector& s0) {
  CpuLimit limit(seconds);
  SolverOptions o{.tol = tol, .time_limit = CpuLimit::kWallFactor * seconds, .s0 = s0};
  o.cancelled = [&limit] { return limit(); };
  SolveResult r = solve(solver, problem, o);
  if (r.status == SolveStatus::kInterrupted && limit.reached()) r.status = SolveStatus::kTimeLimit;
  return r;
}

}  // namespace bipot
