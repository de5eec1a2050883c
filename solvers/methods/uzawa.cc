#include "solvers/methods/uzawa.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "solvers/kernels/contact_iteration.h"
#include "solvers/kernels/predictor_steps.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

// The constants that He and Liao recommend.
constexpr double kLargestRatio = 0.9, kSmallestRatio = 0.4;
constexpr double kStepShrink = 2.0 / 3, kStepGrow = 1.5, kRelaxation = 1.9;
constexpr int kTrials = 30;  // rho has shrunk by at least 1e-5 then: the ratio is rounding

/// The extragradient method of He and Liao on x = impulse ∘ s.
template <int D>
class Extragradient {
 public:
  Extragradient(const ContactProblem& p, const DelassusOperator& delassus,
                const ContactScaling& scaling)
      : p_(p), delassus_(delassus), scaling_(scaling) {}

  void run(const Vector& s0, double rho, IterationMonitor& monitor) {
    Vector x = scaling_.impulse.cwiseProduct(s0), f(x.size()), predicted(x.size());
    Vector f_predicted(x.size()), difference, d;
    map(x, f);
    for (int iteration = 0;; ++iteration) {
      if (monitor.due(iteration)) {
        s_ = x.cwiseQuotient(scaling_.impulse);
        if (monitor.stop(iteration, s_, rho)) return;
      }
      double ratio = 0;
      for (int trial = 0; trial < kTrials; ++trial) {
        project(x, rho, f, predicted);
        map(predicted, f_predicted);
        difference = x - predicted;
        d = f - f_predicted;
        const double moved = difference.norm();
        ratio = moved > 0 ? rho * d.norm() / moved : 0;
        if (!(ratio > kLargestRatio)) break;
        rho *= kStepShrink * std::min(1.0, 1 / ratio);
      }
      d = difference - rho * d;
      const double length = d.squaredNorm();
      const double alpha = length > 0 ? difference.dot(d) / length : 1;
      project(x, kRelaxation * alpha * rho, f_predicted, predicted);
      x.swap(predicted);
      map(x, f);
      if (ratio < kSmallestRatio) rho *= kStepGrow;
    }
  }

 private:
  /// f = de Saxcé's velocity at x.
  void map(const Vector& x, Vector& f) {
    s_ = x.cwiseQuotient(scaling_.impulse);
    delassus_.velocity(s_, f);
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const Local<D> w = f.segment<D>(c * D).cwiseProduct(scaling_.velocity.segment<D>(c * D));
      f.segment<D>(c * D) = de_saxce_velocity<D>(w, scaling_.mu[c]);
    }
  }
  void project(const Vector& x, double rho, const Vector& f, Vector& result) const {
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const Local<D> tau = x.segment<D>(c * D) - rho * f.segment<D>(c * D);
      result.segment<D>(c * D) = project_coulomb_cone<D>(tau, scaling_.mu[c]);
    }
  }

  const ContactProblem& p_;
  const DelassusOperator& delassus_;
  const ContactScaling& scaling_;
  Vector s_;
};

/// Gauss-Seidel sweeps with one self-adaptive step per contact.
template <int D>
void adaptive_sweeps(const ContactProblem& p, PredictorSteps steps, const Vector& s0,
                     IterationMonitor& monitor) {
  const BipotentialCorrector<D> corrector{steps};
  const ContactScaling& scaling = steps.scaling;
  const auto de_saxce = [&](int c, const Local<D>& u) {
    const Local<D> w = u.cwiseProduct(Local<D>(scaling.velocity.segment<D>(c * D)));
    return de_saxce_velocity<D>(w, scaling.mu[c]);
  };
  with_sweep<D>(p, [&](auto sweep) {
    sweep.reset(s0);
    int iteration = 0;
    while (
        !(monitor.due(iteration) && monitor.stop(iteration, sweep.impulse(), steps.rho.mean()))) {
      for (int c = 0; c < p.num_contacts(); ++c) {
        const Local<D> s = sweep.impulse(c);
        const Local<D> u = sweep.velocity(c);
        const Local<D> f = de_saxce(c, u);
        double ratio = 0;
        for (int trial = 0; trial < kTrials; ++trial) {
          const Local<D> predicted = corrector(c, s, u);
          sweep.set(c, predicted);
          const Local<D> moved =
              (predicted - s).cwiseProduct(Local<D>(scaling.impulse.segment<D>(c * D)));
          const double length = moved.norm();
          const double change = (de_saxce(c, sweep.velocity(c)) - f).norm();
          ratio = length > 0 ? steps.rho[c] * change / length : 0;
          if (!(ratio > kLargestRatio)) break;
          steps.rho[c] *= kStepShrink * std::min(1.0, 1 / ratio);
        }
        if (ratio > 0 && ratio < kSmallestRatio) steps.rho[c] *= kStepGrow;
      }
      ++iteration;
    }
  });
}

}  // namespace

SolveResult solve_uzawa(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kUzawaParameters);
  const bool jacobi = parameters.choice("refresh") == "jacobi";
  const std::string rho = parameters.choice("rho");
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const PredictorSteps steps =
      rho == "paper" ? paper_steps(p, delassus) : stable_steps(p, delassus, jacobi);
  const Vector s0 = start_of(p, options);
  monitor.end_setup();
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    const BipotentialCorrector<D> update{steps};
    if (rho == "adaptive" && jacobi) {
      Extragradient<D>(p, delassus, steps.scaling).run(s0, steps.rho[0], monitor);
    } else if (rho == "adaptive") {
      adaptive_sweeps<D>(p, steps, s0, monitor);
    } else if (jacobi) {
      iterate_jacobi<D>(p, delassus, s0, steps.rho[0], monitor, update);
    } else {
      iterate_gauss_seidel<D>(p, s0, steps.rho[0], monitor, update);
    }
  });
  return monitor.finish();
}

}  // namespace bipot
