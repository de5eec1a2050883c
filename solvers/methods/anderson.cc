#include "solvers/methods/anderson.h"

#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "solvers/kernels/anderson_iteration.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/local_updates.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

/// Products over the rows of a problem on one process.
struct LoneProducts {
  template <class A>
  double norm(const A& a) const {
    return a.norm();
  }
  /// Of the first `size` columns with f.
  Vector products(const Eigen::MatrixXd& columns, int size, const Vector& f) const {
    return columns.leftCols(size).transpose() * f;
  }
};

}  // namespace

SolveResult solve_anderson(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kAndersonParameters);
  const int columns = parameters.integer("memory");
  const bool sweeps = parameters.choice("map") == "sweep";
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const ContactScaling scaling = equilibrated_scaling(p, delassus.diagonal());
  const Vector s0 = start_of(p, options);
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    if (sweeps) {
      with_local_updates<D>(p, delassus, {}, false, [&](auto& sweep, auto visit) {
        monitor.end_setup();
        iterate_anderson(LoneProducts{}, scaling, s0, columns, monitor, [&](Vector& s) {
          sweep.reset(s);
          for (int c = 0; c < p.num_contacts(); ++c) visit(c);
          for (int c = p.num_contacts() - 1; c >= 0; --c) visit(c);
          s = sweep.impulse();
        });
      });
    } else {
      const double rho = 1 / (kSpectralMargin * spectral_estimate(p, delassus, scaling.velocity));
      Vector u(p.num_rows());
      monitor.end_setup();
      iterate_anderson(LoneProducts{}, scaling, s0, columns, monitor, [&](Vector& s) {
        delassus.velocity(s, u);
        for (int c = 0; c < p.num_contacts(); ++c) {
          const Local<D> to_x = scaling.impulse.segment<D>(c * D);
          Local<D> x = s.segment<D>(c * D).cwiseProduct(to_x);
          x -= rho * u.segment<D>(c * D).cwiseQuotient(to_x);
          x[0] = positive_part(x[0]);
          if constexpr (D > 1) {
            const double norm = tangential_norm<D>(x), radius = scaling.mu[c] * x[0];
            if (norm > radius) x.template tail<D - 1>() *= radius / norm;
          }
          s.segment<D>(c * D) = x.cwiseQuotient(to_x);
        }
      });
    }
  });
  return monitor.finish();
}

}  // namespace bipot
