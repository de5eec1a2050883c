#include "solvers/methods/convex.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/gradient_iteration.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

constexpr int kAssociatedSteps = 8;  // of the gradient, between two looks at the associated law
constexpr double kFarther = 1e-3;  // error of the associated law over that of Coulomb's, at the end

/// The number of closed contacts that slide, and how quickly they open.
template <ContactRows D>
std::string opening(const ContactProblem& p, const Vector& s, const Vector& u) {
  int sliding = 0;
  double fastest = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Local<D> own = local<D>(s, c);
    bool slides = false;
    each_bounded<D>(friction_of<D>(p, c), [&](auto first, auto count, double bound) {
      const double radius = bound * own[0];
      slides |= radius > 0 && part_norm<first(), count()>(own) >= kConeEdge * radius;
    });
    if (!slides) continue;
    ++sliding;
    const double r = p.row_scale.size() > 0 ? p.row_scale[c * D] : 1;
    fastest = std::max(fastest, u[c * D] / r);
  }
  return fmt::format("{} of {} contacts {} up to {:.3g} m/s", sliding, p.num_contacts(),
                     D.rolls ? "slide or roll, and open with" : "slide, and open with mu |u_t|",
                     fastest);
}

template <ContactRows D>
void iterate_associated(SolveRun& run) {
  const ContactProblem& p = run.problem();
  const ContactScaling scaling = equilibrated_scaling(p, run.space().diagonal());
  SpaceSums sums{run.space()};
  GradientIteration<D, SpaceSums> kernel(p, sums, scaling);
  GradientKernel::Control control{
      .lambda = kSpectralMargin * spectral_estimate(run.space(), scaling.velocity),
      .map = GradientMap::kFollowed};  // and sigma = 0
  const double energy = kTheta * run.space().energy_at_rest();
  run.end_setup();
  kernel.reset(run.start());
  StagnationTest stagnation(10000);
  double own = kInfinity, best = kInfinity;  // errors of the associated law
  for (int iteration = 0;;) {
    if (run.due(iteration)) {
      if (run.stop(iteration, kernel.impulse(), control.lambda, /*moving=*/true)) return;
      const bool other = own <= run.options().tol && own <= kFarther * run.last_error();
      if (other || stagnation.stagnates(iteration, best)) {
        // Its own answer, and not the iterate that is nearest to Coulomb's law.
        const Vector s = run.space().impulse(), u = run.space().impulse_velocity();
        run.take({.status = SolveStatus::kStalled,
                  .message = fmt::format("another law: the associated one holds to {:.1e}; {}; "
                                         "error of Coulomb's law {:.2e}",
                                         own, opening<D>(p, s, u), run.last_error()),
                  .s = s,
                  .iterations = iteration,
                  .solve_seconds = run.seconds()});
        return;
      }
    }
    const int count = run.undue(iteration, kAssociatedSteps);
    kernel.advance(count, control);
    iteration += count;
    own = std::sqrt(kernel.template held_residual<GradientMap::kFollowed>() / energy);
    best = std::min(best, own);
    if (own <= run.options().tol) run.judge_next();
  }
}

}  // namespace

void solve_convex(SolveRun& run) {
  if (run.options().stop == StopTest::kImpulse) {
    return run.end(SolveStatus::kInvalidInput,
                   "convex solves another law, which the stop test impulse does not see");
  }
  dispatch_rows(run.problem(), [&](auto d) { iterate_associated<d()>(run); });
}

}  // namespace bipot
