#include "solvers/methods/tresca.h"

#include <fmt/format.h>

#include <algorithm>

#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/gradient_iteration.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

constexpr int kHeldSteps = 8;  // of the gradient, between two looks at the problem with held bounds
constexpr double kBoundsStand = 1e-15;  // relative change of bounds that stand

template <ContactRows D>
void iterate_bounds(SolveRun& run) {
  const ContactScaling scaling = equilibrated_scaling(run.problem(), run.space().diagonal());
  SpaceSums sums{run.space()};
  GradientIteration<D, SpaceSums> kernel(run.problem(), sums, scaling);
  GradientKernel::Control control{
      .lambda = kSpectralMargin * spectral_estimate(run.space(), scaling.velocity),
      .map = GradientMap::kHeldDisk};
  const double accuracy = run.parameters().number("bound_accuracy");
  const double energy = kTheta * run.space().energy_at_rest();
  run.end_setup();
  kernel.reset(run.start());
  kernel.hold_disks();
  StagnationTest stagnation(10000);
  int bounds = 1;
  bool settled = false;
  for (int iteration = 0;;) {
    if (run.due(iteration) && run.stop(iteration, kernel.impulse(), control.lambda, !settled)) {
      break;
    }
    const int count = run.undue(iteration, kHeldSteps);
    kernel.advance(count, control);
    iteration += count;
    const double residual = kernel.template held_residual<GradientMap::kHeldDisk>();
    const double target = std::max(accuracy * run.last_error(), 0.1 * run.options().tol);
    if (!(residual <= target * target * energy)) continue;
    run.judge_next();
    const auto [change, size] = kernel.hold_disks();
    settled = change <= kBoundsStand * size;
    if (settled) continue;  // the same problem: it keeps its momentum
    control.t = 1;
    if (++bounds > 2 && stagnation.stagnates(iteration, run.best_error())) {
      run.end(
          SolveStatus::kStalled,
          fmt::format("the bounds of friction do not settle, best error {:.2e}", run.best_error()));
      break;
    }
  }
  run.remark(fmt::format("; {} sets of bounds", bounds));
}

}  // namespace

void solve_tresca(SolveRun& run) {
  dispatch_rows(run.problem(), [&](auto d) { iterate_bounds<d()>(run); });
}

}  // namespace bipot
