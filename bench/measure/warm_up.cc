#include "bench/measure/warm_up.h"

#include "solvers/solve.h"

namespace bipot {

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
