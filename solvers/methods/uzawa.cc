#include "solvers/methods/uzawa.h"

#include "core/problem/delassus.h"
#include "solvers/kernels/contact_iteration.h"
#include "solvers/kernels/predictor_steps.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {

SolveResult solve_uzawa(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kUzawaParameters);
  const bool jacobi = parameters.choice("refresh") == "jacobi";
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const PredictorSteps steps = parameters.choice("rho") == "paper"
                                   ? paper_steps(p, delassus)
                                   : stable_steps(p, delassus, jacobi);
  const Vector s0 = start_of(p, options);
  monitor.end_setup();
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    const BipotentialCorrector<D> update{steps};
    if (jacobi) {
      iterate_jacobi<D>(p, delassus, s0, steps.rho[0], monitor, update);
    } else {
      iterate_gauss_seidel<D>(p, s0, steps.rho[0], monitor, update);
    }
  });
  return monitor.finish();
}

}  // namespace bipot
