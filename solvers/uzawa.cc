#include "solvers/uzawa.h"

#include <cmath>

#include "core/coulomb_cone.h"
#include "core/delassus.h"
#include "solvers/contact_scaling.h"
#include "solvers/contact_sweep.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

/// Predictor-corrector (41) of every contact, in scaled variables.
struct Steps {
  ContactScaling scaling;
  Vector rho;  // one per contact

  template <int D>
  Local<D> operator()(int c, const Local<D>& s, const Local<D>& u) const {
    const Local<D> to_x = local<D>(scaling.impulse, c);
    const Local<D> x = s.cwiseProduct(to_x);
    const Local<D> w = u.cwiseProduct(local<D>(scaling.velocity, c));
    const Local<D> tau = x - rho[c] * de_saxce_velocity<D>(w, scaling.mu[c]);
    return project_coulomb_cone<D>(tau, scaling.mu[c]).cwiseQuotient(to_x);
  }
};

/// ‖diag(scale) W diag(scale)‖_inf from |H| (two passes) or |W|: an upper bound of lambda_max.
double spectral_bound(const ContactProblem& p, const Vector& scale) {
  Vector sums;
  if (p.has_velocities() && is_diagonal(p.A)) {
    const SparseMatrix absolute = p.H.cwiseAbs();
    const Vector inverse_mass = p.A.diagonal().cwiseInverse();
    const Vector velocity = inverse_mass.cwiseProduct(Vector(absolute * scale));
    sums = absolute.transpose() * velocity;
  } else {
    const SparseRows absolute = p.W.cwiseAbs();
    sums = absolute * scale;
  }
  return sums.cwiseProduct(scale).maxCoeff();
}

Steps make_steps(const ContactProblem& p, const DelassusOperator& delassus, bool paper,
                 bool jacobi) {
  const Vector diagonal = delassus.diagonal();
  Steps steps;
  steps.rho.resize(p.num_contacts());
  if (paper) {
    steps.scaling = physical_scaling(p);
    for (int c = 0; c < p.num_contacts(); ++c) steps.rho[c] = 1 / diagonal[c * p.dim];
  } else {
    steps.scaling = equilibrated_scaling(p, diagonal);
    steps.rho.setConstant(jacobi ? 1.9 / spectral_bound(p, steps.scaling.velocity) : 1.0);
  }
  return steps;
}

template <int D>
void jacobi(const ContactProblem& p, const Steps& step, const DelassusOperator& delassus, Vector s,
            IterationMonitor& monitor) {
  Vector u(p.num_rows());
  for (int iteration = 0; !monitor.stop(iteration, s, step.rho[0]); ++iteration) {
    delassus.velocity(s, u);
    for (int c = 0; c < p.num_contacts(); ++c) {
      s.segment<D>(c * D) = step(c, local<D>(s, c), local<D>(u, c));
    }
  }
}

template <int D>
void gauss_seidel(const ContactProblem& p, const Steps& step, const Vector& s0,
                  IterationMonitor& monitor) {
  with_sweep<D>(p, [&](auto sweep) {
    sweep.reset(s0);
    int iteration = 0;
    while (!(monitor.due(iteration) && monitor.stop(iteration, sweep.impulse(), step.rho[0]))) {
      for (int c = 0; c < p.num_contacts(); ++c) {
        sweep.set(c, step(c, sweep.impulse(c), sweep.velocity(c)));
      }
      ++iteration;
    }
    return 0;
  });
}

}  // namespace

SolveResult solve_uzawa(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kUzawaParameters);
  const bool is_jacobi = parameters.choice("refresh") == "jacobi";
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const Steps steps = make_steps(p, delassus, parameters.choice("rho") == "paper", is_jacobi);
  const Vector s0 = options.s0.size() != 0 ? options.s0 : Vector(Vector::Zero(p.num_rows()));
  monitor.end_setup();
  dispatch_dim(p.dim, [&](auto d) {
    if (is_jacobi) {
      jacobi<d()>(p, steps, delassus, s0, monitor);
    } else {
      gauss_seidel<d()>(p, steps, s0, monitor);
    }
    return 0;
  });
  return monitor.finish();
}

}  // namespace bipot
