#include "solvers/methods/accelerated_gradient.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/kernels/tiled_gradient.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

enum class Map { kSplit, kCone };

/// x⁺ of one contact from the extrapolated impulse y and its velocity w.
template <int D, Map kMap>
inline Local<D> corrected(const Local<D>& y, const Local<D>& w, double mu, double rho) {
  if constexpr (kMap == Map::kCone) {
    return project_coulomb_cone<D>(y - rho * de_saxce_velocity<D>(w, mu), mu);
  } else {
    Local<D> x = y - rho * w;
    x[0] = std::max(x[0], 0.0);
    if constexpr (D == 2) {
      const double radius = mu * x[0];
      x[1] = std::clamp(x[1], -radius, radius);
    } else if constexpr (D == 3) {
      const double norm = tangential_norm<D>(x), radius = mu * x[0];
      if (norm > radius) x.template tail<D - 1>() *= radius / norm;
    }
    return x;
  }
}

/// Sums over the contacts of one step from x to x⁺ by way of y.
struct Progress {
  double turn = 0;     // (y - x⁺)·(x⁺ - x): positive when momentum points uphill
  double change2 = 0;  // ‖x⁺ - x‖²
};

/// The iteration through the Delassus operator, any problem. Disks: tiled_gradient.h.
template <int D>
class GeneralKernel {
 public:
  GeneralKernel(const ContactProblem& p, const DelassusOperator& delassus,
                const ContactScaling& scaling)
      : p_(p), delassus_(delassus), scaling_(scaling) {}

  void reset(const Vector& s) {
    s_ = s;
    x_ = before_ = y_ = scaling_.impulse.cwiseProduct(s);
    delassus_.velocity(s_, w_);
    w_.array() *= scaling_.velocity.array();
    w_before_ = w_y_ = w_;
  }
  const Vector& impulse() {
    s_ = x_.cwiseProduct(scaling_.velocity);
    return s_;
  }
  void advance(int iterations, GradientControl& control) {
    for (; iterations > 0; --iterations) {
      const double rho = control.step / control.lambda;
      const Progress progress = control.cone ? project<Map::kCone>(rho) : project<Map::kSplit>(rho);
      const double t = progress.turn > 0 || !control.momentum ? 1 : control.t;
      control.t = next_momentum(t);
      const double energy = extrapolate((t - 1) / control.t);
      if (energy > control.lambda * progress.change2) {
        // A larger eigenvalue than the estimate has shown itself.
        control.lambda = kSpectralMargin * energy / progress.change2;
        extrapolate(0);
        control.t = 1;
      }
    }
  }

 private:
  template <Map kMap>
  Progress project(double rho) {
    Progress sums;
    before_.swap(x_);
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const Local<D> y = y_.segment<D>(c * D);
      const Local<D> x = corrected<D, kMap>(y, w_y_.segment<D>(c * D), scaling_.mu[c], rho);
      const Local<D> change = x - before_.segment<D>(c * D);
      sums.turn += (y - x).dot(change);
      sums.change2 += change.squaredNorm();
      x_.segment<D>(c * D) = x;
    }
    w_before_.swap(w_);
    s_ = x_.cwiseProduct(scaling_.velocity);
    delassus_.velocity(s_, w_);
    w_.array() *= scaling_.velocity.array();
    return sums;
  }
  double extrapolate(double beta) {
    y_ = x_ + beta * (x_ - before_);
    w_y_ = w_ + beta * (w_ - w_before_);
    return (x_ - before_).dot(w_ - w_before_);
  }

  const ContactProblem& p_;
  const DelassusOperator& delassus_;
  const ContactScaling& scaling_;
  Vector s_, x_, before_, y_, w_, w_before_, w_y_;
};

enum class Choice { kAuto, kSplit, kCone };

/// Which map is in use. With Choice::kAuto, a map that has not halved the best error for as many
/// iterations as it took to get there (and at least kPatience) hands over to the next of: split,
/// cone, split without momentum.
class MapRota {
 public:
  explicit MapRota(Choice choice) : choice_(choice) {}

  Map map() const { return choice_ == Choice::kCone || phase_ == 1 ? Map::kCone : Map::kSplit; }
  bool momentum() const { return phase_ != 2; }

  /// Tells the best error so far. True when the map changes: go back to the best iterate.
  bool advance(int iteration, double best_error) {
    if (choice_ != Choice::kAuto) return false;
    if (best_error <= 0.5 * mark_) {
      mark_ = best_error;
      mark_iteration_ = iteration;
      patience_ = std::max(kPatience, iteration);
    } else if (iteration - mark_iteration_ > patience_) {
      phase_ = (phase_ + 1) % 3;
      mark_iteration_ = iteration;
      patience_ = std::max(kPatience, iteration / 2);
      return true;
    }
    return false;
  }

 private:
  static constexpr int kPatience = 1000;
  Choice choice_;
  int phase_ = 0;
  double mark_ = std::numeric_limits<double>::infinity();
  int mark_iteration_ = 0, patience_ = kPatience;
};

/// Iterations that may be done without a look at the clock.
constexpr int kUnwatchedSteps = 64;

template <class Kernel>
void iterate(Kernel kernel, MapRota rota, const Vector& s0, double lambda, double step,
             IterationMonitor& monitor) {
  kernel.reset(s0);
  GradientControl control{.lambda = lambda, .step = step};
  for (int iteration = 0;;) {
    if (monitor.due(iteration)) {
      if (monitor.stop(iteration, kernel.impulse(), step / control.lambda)) return;
      if (rota.advance(iteration, monitor.best_error())) {
        kernel.reset(monitor.best_impulse());
        control.t = 1;
      }
    }
    control.cone = rota.map() == Map::kCone;
    control.momentum = rota.momentum();
    const int count = monitor.undue(iteration, kUnwatchedSteps);
    kernel.advance(count, control);
    iteration += count;
  }
}

}  // namespace

SolveResult solve_accelerated_gradient(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kAcceleratedGradientParameters);
  const std::string map = parameters.choice("map");
  const MapRota rota(map == "auto" ? Choice::kAuto
                                   : (map == "cone" ? Choice::kCone : Choice::kSplit));
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
        iterate(TiledGradient<D>(p, *delassus.disks(), scaling, options.execution), rota, s0,
                lambda, step, monitor);
        return;
      }
    }
    iterate(GeneralKernel<D>(p, delassus, scaling), rota, s0, lambda, step, monitor);
  });
  return monitor.finish();
}

}  // namespace bipot
