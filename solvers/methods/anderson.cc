#include "solvers/methods/anderson.h"

#include "core/problem/coulomb_cone.h"
#include "solvers/kernels/anderson_iteration.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/parallel/split_sweep.h"

namespace bipot {
namespace {

template <ContactRows D>
void accelerate_sweeps(SolveRun& run, const ContactScaling& scaling, int columns) {
  const int contacts = run.problem().num_contacts();
  with_sweep_of<D>(run, {}, false, [&](auto& sweep, auto visit, auto meet) {
    run.end_setup();
    iterate_anderson(run, scaling, columns, [&](Vector& s) {
      sweep.reset(s);
      meet();
      for (int c = 0; c < contacts; ++c) visit(c);
      for (int c = contacts - 1; c >= 0; --c) visit(c);
      s = sweep.impulse();
    });
  });
}

template <ContactRows D>
void accelerate_gradient(SolveRun& run, const ContactScaling& scaling, int columns) {
  const double rho = 1 / (kSpectralMargin * spectral_estimate(run.space(), scaling.velocity));
  Vector u(run.problem().num_rows());
  run.end_setup();
  iterate_anderson(run, scaling, columns, [&](Vector& s) {
    run.space().velocity(s, u);
    for (int c = 0; c < run.problem().num_contacts(); ++c) {
      const Local<D> to_x = scaling.impulse.segment<D>(c * D);
      Local<D> x = s.segment<D>(c * D).cwiseProduct(to_x);
      x -= rho * u.segment<D>(c * D).cwiseQuotient(to_x);
      x[0] = positive_part(x[0]);
      cut_off_parts<D>(x, friction_of<D>(scaling, c));
      s.segment<D>(c * D) = x.cwiseQuotient(to_x);
    }
  });
}

}  // namespace

Parallel anderson_in_parallel(const Parameters& parameters) {
  return parameters.choice("map") == "gradient" ? Parallel::kReproducible : Parallel::kYes;
}

void solve_anderson(SolveRun& run) {
  const int columns = run.parameters().integer("memory");
  const bool sweeps = run.parameters().choice("map") == "sweep";
  const ContactScaling scaling = equilibrated_scaling(run.problem(), run.space().diagonal());
  dispatch_rows(run.problem(), [&](auto d) {
    if (sweeps) {
      accelerate_sweeps<d()>(run, scaling, columns);
    } else {
      accelerate_gradient<d()>(run, scaling, columns);
    }
  });
}

}  // namespace bipot
