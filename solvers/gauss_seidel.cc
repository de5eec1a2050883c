#include "solvers/gauss_seidel.h"

#include "core/coulomb_cone.h"
#include "core/delassus.h"
#include "solvers/contact_sweep.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

struct LocalSteps {
  Vector normal, tangential;  // 1/W_nn and (d-1)/tr W_tt, one per contact
};

LocalSteps local_steps(const ContactProblem& p, const Vector& diagonal) {
  const int d = p.dim;
  LocalSteps steps{Vector(p.num_contacts()), Vector(p.num_contacts())};
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double w_nn = diagonal[c * d];
    double w_tt = 0;
    for (int k = 1; k < d; ++k) w_tt += diagonal[c * d + k] / (d - 1);
    steps.normal[c] = 1 / w_nn;
    steps.tangential[c] = w_tt > 1e-12 * w_nn ? 1 / w_tt : 1 / w_nn;
  }
  return steps;
}

}  // namespace

SolveResult solve_gauss_seidel(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kGaussSeidelParameters);
  const double omega = parameters.number("omega");
  IterationMonitor monitor(p, options);
  const LocalSteps steps = local_steps(p, monitor.evaluator().delassus().diagonal());
  const Vector s0 = options.s0.size() != 0 ? options.s0 : Vector(Vector::Zero(p.num_rows()));
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    return with_sweep<D>(p, [&](auto sweep) {
      sweep.reset(s0);
      monitor.end_setup();
      int iteration = 0;
      while (!(monitor.due(iteration) && monitor.stop(iteration, sweep.impulse(), omega))) {
        for (int c = 0; c < p.num_contacts(); ++c) {
          const Local<D> u = sweep.velocity(c);
          Local<D> s = sweep.impulse(c);
          // Signorini first, then the friction disk of radius mu s_n: with a diagonal local block
          // this pair solves the local problem exactly.
          s[0] = std::max(0.0, s[0] - omega * steps.normal[c] * u[0]);
          if constexpr (D > 1) {
            auto tangent = s.template tail<D - 1>();
            tangent -= omega * steps.tangential[c] * u.template tail<D - 1>();
            const double norm = tangential_norm<D>(s);
            const double radius = p.mu[c] * s[0];
            if (norm > radius) tangent *= radius / norm;
          }
          sweep.set(c, s);
        }
        ++iteration;
      }
      return 0;
    });
  });
  return monitor.finish();
}

}  // namespace bipot
