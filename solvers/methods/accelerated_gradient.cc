#include "solvers/methods/accelerated_gradient.h"

#include <string>

#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "solvers/disks/tiled_gradient.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/gradient_iteration.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

/// The sums of an iteration on one process.
struct LoneSums {
  const DelassusOperator& delassus;

  using Sum = double;
  void velocity(const Vector& s, Vector& u) { delassus.velocity(s, u); }
  template <class A, class B>
  void add_dot(const A& a, const B& b, Sum& sum) const {
    sum += a.dot(b);
  }
  GradientProgress total(Sum turn, Sum change2, Sum energy) const {
    return {turn, change2, energy};
  }
};

}  // namespace

SolveResult solve_accelerated_gradient(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kAcceleratedGradientParameters);
  const std::string map = parameters.choice("map");
  const MapRota rota(map);
  const double step = parameters.number("step");
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const ContactScaling scaling = equilibrated_scaling(p, delassus.diagonal());
  const double lambda = kSpectralMargin * spectral_estimate(p, delassus, scaling.velocity);
  const Vector s0 = start_of(p, options);
  monitor.end_setup();
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    if constexpr (D < 3) {
      if (delassus.disks()) {
        TiledGradient<D> kernel(p, *delassus.disks(), scaling, options.execution);
        iterate_gradient(kernel, rota, s0, lambda, step, monitor);
        return;
      }
    }
    LoneSums sums{delassus};
    GradientIteration<D, LoneSums> kernel(p, sums, scaling);
    iterate_gradient(kernel, rota, s0, lambda, step, monitor);
  });
  return monitor.finish();
}

}  // namespace bipot
