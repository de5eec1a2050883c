#include "solvers/methods/uzawa.h"

#include "core/problem/coulomb_cone.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/contact_sweep.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

/// Variables and steps of the predictors of `uzawa` and `classical`.
struct PredictorSteps {
  ContactScaling scaling;
  Vector rho;  ///< one per contact, in the scaled variables

  /// Of the first contact, for the history.
  double first() const { return rho.size() > 0 ? rho[0] : kNaN; }
};

/// rho = paper: rho = (1 + e_n) m_i m_j / (m_i + m_j) = 1/W_nn of the step's operator, in physical
/// variables, for the normal and tangential part alike. For a disk W_tt = 3 W_nn, so that a
/// sticking contact lies outside the stable range of a fixed step. This choice reproduces the paper
/// and its limits.
PredictorSteps paper_steps(ContactSpace& space) {
  const ContactProblem& p = space.problem();
  const Vector diagonal = space.diagonal();
  PredictorSteps steps{physical_scaling(p, diagonal), Vector(p.num_contacts())};
  for (int c = 0; c < p.num_contacts(); ++c) steps.rho[c] = 1 / diagonal[c * p.dim];
  return steps;
}

/// rho = stable [ours]: variables scaled so that W has a unit diagonal (one scale for all tangents
/// of a contact; mu changes by the ratio of the scales), then
///   - jacobi: rho = 1.9 / ‖W‖_inf <= 1.9 / lambda_max(W). For mu = 0 this is the projected
///     gradient of a convex quadratic with a step below 2/lambda_max, which converges (Goldstein
///     1964, Levitin and Polyak 1966). With friction the problem is not a minimisation and no step
///     is proved to converge.
///   - gauss-seidel: rho = 1. For mu = 0 each update minimises exactly along its coordinate, and
///     the cyclic sweep converges (Luo and Tseng 1992).
PredictorSteps stable_steps(ContactSpace& space, bool jacobi) {
  const ContactProblem& p = space.problem();
  PredictorSteps steps{equilibrated_scaling(p, space.diagonal()), {}};
  steps.rho = Vector::Constant(p.num_contacts(),
                               jacobi ? 1.9 / space.norm_bound(steps.scaling.velocity) : 1.0);
  return steps;
}

/// The update of every contact, in scaled variables: predictor-corrector (41), or the two of
/// `classical`.
template <ContactRows D, bool kClassical>
struct Corrector {
  const PredictorSteps& steps;

  [[gnu::always_inline]] Local<D> operator()(int c, const Local<D>& s, const Local<D>& u) const {
    const ContactScaling& scaling = steps.scaling;
    const Local<D> to_x = scaling.impulse.segment<D>(c * D);
    const Local<D> x = s.cwiseProduct(to_x);
    const Local<D> w = u.cwiseProduct(Local<D>(scaling.velocity.segment<D>(c * D)));
    const auto friction = friction_of<D>(scaling, c);
    if constexpr (kClassical) {
      Local<D> tau = x - steps.rho[c] * w;
      tau[0] = positive_part(tau[0]);
      cut_off_parts<D>(tau, friction);
      return tau.cwiseQuotient(to_x);
    } else {
      const Local<D> tau = x - steps.rho[c] * de_saxce_velocity<D>(w, friction);
      return project_coulomb_cone<D>(tau, friction).cwiseQuotient(to_x);
    }
  }
};

/// Jacobi sweeps: s_c <- update(c, s_c, u_c) for all contacts, with the velocities of the iterate
/// before. `step` goes into the history.
template <int D, class Update>
void iterate_jacobi(SolveRun& run, double step, const Update& update) {
  const ContactProblem& p = run.problem();
  Vector s = run.start(), u(p.num_rows());
  for (int iteration = 0; !run.stop(iteration, s, step); ++iteration) {
    run.space().velocity(s, u);
    for (int c = 0; c < p.num_contacts(); ++c) {
      s.segment<D>(c * D) = update(c, local<D>(s, c), local<D>(u, c));
    }
  }
}

/// Gauss-Seidel sweeps: the same with velocities updated after each contact.
template <int D, class Update>
void iterate_gauss_seidel(SolveRun& run, double step, const Update& update) {
  const ContactProblem& p = run.problem();
  with_sweep<D>(p, run.delassus(), [&](auto sweep) {
    sweep.reset(run.start());
    int iteration = 0;
    while (!(run.due(iteration) && run.stop(iteration, sweep.impulse(), step))) {
      for (int c = 0; c < p.num_contacts(); ++c) {
        sweep.set(c, update(c, sweep.impulse(c), sweep.velocity(c)));
      }
      ++iteration;
    }
  });
}

/// Iterates s_c <- corrector(c, s_c, u_c) with the parameters of `uzawa`.
template <bool kClassical>
void iterate_correctors(SolveRun& run) {
  const bool jacobi = run.parameters().choice("refresh") == "jacobi";
  const PredictorSteps steps = run.parameters().choice("rho") == "paper"
                                   ? paper_steps(run.space())
                                   : stable_steps(run.space(), jacobi);
  run.end_setup();
  dispatch_rows(run.problem(), [&](auto d) {
    const Corrector<d(), kClassical> update{steps};
    if (jacobi) {
      iterate_jacobi<d()>(run, steps.first(), update);
    } else {
      iterate_gauss_seidel<d()>(run, steps.first(), update);
    }
  });
}

}  // namespace

Parallel jacobi_in_parallel(const Parameters& parameters) {
  return parameters.choice("refresh") == "jacobi" ? Parallel::kReproducible : Parallel::kNo;
}

void solve_uzawa(SolveRun& run) { iterate_correctors<false>(run); }
void solve_classical(SolveRun& run) { iterate_correctors<true>(run); }

}  // namespace bipot
