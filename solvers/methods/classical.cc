#include "solvers/methods/classical.h"

#include "core/problem/coulomb_cone.h"
#include "solvers/kernels/contact_iteration.h"
#include "solvers/kernels/predictor_steps.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

template <int D>
struct TwoCorrectors {
  const PredictorSteps& steps;

  Local<D> operator()(int c, const Local<D>& s, const Local<D>& u) const {
    const ContactScaling& scaling = steps.scaling;
    const Local<D> to_x = scaling.impulse.segment<D>(c * D);
    const double rho = steps.rho[c];
    Local<D> x =
        s.cwiseProduct(to_x) - rho * u.cwiseProduct(Local<D>(scaling.velocity.segment<D>(c * D)));
    x[0] = positive_part(x[0]);
    if constexpr (D > 1) {
      const double norm = tangential_norm<D>(x), radius = scaling.mu[c] * x[0];
      if (norm > radius) x.template tail<D - 1>() *= radius / norm;
    }
    return x.cwiseQuotient(to_x);
  }
};

}  // namespace

SolveResult solve_classical(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kClassicalParameters);
  const bool jacobi = parameters.choice("refresh") == "jacobi";
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const PredictorSteps steps = parameters.choice("rho") == "paper"
                                   ? paper_steps(p, delassus)
                                   : stable_steps(p, delassus, jacobi);
  const Vector s0 = start_of(p, options);
  monitor.end_setup();
  dispatch_dim(p.dim, [&](auto d) {
    const TwoCorrectors<d()> update{steps};
    if (jacobi) {
      iterate_jacobi<d()>(p, delassus, s0, steps.rho[0], monitor, update);
    } else {
      iterate_gauss_seidel<d()>(p, s0, steps.rho[0], monitor, update);
    }
  });
  return monitor.finish();
}

}  // namespace bipot
