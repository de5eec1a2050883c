#include "solvers/methods/accelerated_gradient.h"

#include "solvers/disks/rolling_bodies.h"
#include "solvers/disks/tiled_gradient.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/gradient_iteration.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/parallel/disk_frontier.h"

namespace bipot {
namespace {

/// Calls f(kernel) with the vectorised iteration on disks of several processes. False if the problem
/// is another one.
template <int D, class F>
bool with_frontier_kernel(SolveRun& run, const ContactScaling& scaling, F&& f) {
  DistributedSpace& parts = *run.space().parts();
  if (parts.exact()) return false;
  std::optional<DiskStructure> disks = DiskFrontier<D>::structure(parts);
  if (!disks) return false;
  DiskFrontier<D> frontier(parts);
  TiledGradient<D> kernel(run.problem(), *disks, scaling, run.options().execution, &frontier);
  disks.reset();  // packed: 48 bytes a contact less
  f(kernel);
  return true;
}

/// The same with the iteration through the operator.
template <ContactRows D, class F>
void with_any_kernel(SolveRun& run, const ContactScaling& scaling, F&& f) {
  DistributedSpace* const parts = run.space().parts();
  if (parts != nullptr && parts->exact()) {
    ExactSums sums{*parts};
    GradientIteration<D, ExactSums> kernel(run.problem(), sums, scaling);
    f(kernel);
  } else {
    SpaceSums sums{run.space()};
    GradientIteration<D, SpaceSums> kernel(run.problem(), sums, scaling);
    f(kernel);
  }
}

}  // namespace

void solve_accelerated_gradient(SolveRun& run) {
  const MapSchedule schedule(run.parameters().choice("map"));
  const int hold = run.parameters().integer("hold");
  const double step = run.parameters().number("step");
  const ContactScaling scaling = equilibrated_scaling(run.problem(), run.space().diagonal());
  const double lambda = kSpectralMargin * spectral_estimate(run.space(), scaling.velocity);
  run.end_setup();
  const auto iterate = [&](GradientKernel& kernel) {
    iterate_gradient(kernel, schedule, hold, lambda, step, run);
  };
  dispatch_rows(run.problem(), [&](auto d) {
    constexpr ContactRows D = d();
    if (run.space().parts() == nullptr) {
      if (const auto bodies = kernel_bodies<D>(run.problem(), run.delassus())) {
        TiledGradient<kKernelOf<D>> kernel(run.problem(), *bodies, scaling,
                                           run.options().execution);
        return iterate(kernel);
      }
    } else if constexpr (!D.rolls && D < 3) {
      if (with_frontier_kernel<D>(run, scaling, iterate)) return;
    }
    with_any_kernel<D>(run, scaling, iterate);
  });
}

}  // namespace bipot
