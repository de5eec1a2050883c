#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "core/problem/coulomb_cone.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/gradient_kernel.h"
#include "solvers/kernels/spectral_estimate.h"
#include "solvers/kernels/stagnation_test.h"
#include "solvers/solve_run.h"

namespace bipot {

// The accelerated projected gradient of solvers/methods/accelerated_gradient.h, for one process and
// in parallel.

/// x⁺ of one contact from the extrapolated impulse y and its velocity w. `held`: sigma of the map
/// kFollowed, the radius of kHeldDisk; with rolling friction the s_n from which its radii follow.
template <int D, GradientMap kMap, class Friction>
inline Local<D> corrected(const Local<D>& y, Local<D> w, const Friction& mu, double held,
                          double rho) {
  if constexpr (kMap == GradientMap::kFollowed) {
    w[0] += held;
    return project_coulomb_cone<D>(y - rho * w, mu);
  } else if constexpr (!std::is_same_v<Friction, double>) {
    Local<D> x = y - rho * w;
    const double normal = std::max(x[0], 0.0);
    x[0] = kMap == GradientMap::kHeldDisk ? held : normal;
    cut_off_parts<D>(x, mu);
    x[0] = normal;
    return x;
  } else {
    Local<D> x = y - rho * w;
    x[0] = std::max(x[0], 0.0);
    const double radius = kMap == GradientMap::kHeldDisk ? held : mu * x[0];
    if constexpr (D == 2) {
      x[1] = std::clamp(x[1], -radius, radius);
    } else if constexpr (D == 3) {
      const double norm = tangential_norm<D>(x);
      if (norm > radius) x.template tail<D - 1>() *= radius / norm;
    }
    return x;
  }
}

/// The iteration through the Delassus operator, for any problem. (Disks on one process:
/// tiled_gradient.h.) `Space` includes the contacts of other processes: velocity(s, u) is u = W s +
/// u_free, a Sum has += and add_dot(a, b, sum), and total() adds the Sums over all processes.
template <ContactRows D, class Space>
class GradientIteration final : public GradientKernel {
 public:
  GradientIteration(const ContactProblem& p, Space& space, const ContactScaling& scaling)
      : p_(p), space_(space), scaling_(scaling) {}

  void reset(const Vector& s) override {
    s_ = s;
    x_ = before_ = y_ = scaling_.impulse.cwiseProduct(s);
    space_.velocity(s_, w_);
    w_.array() *= scaling_.velocity.array();
    w_before_ = w_y_ = w_;
    held_.setZero(p_.num_contacts());
  }
  const Vector& impulse() override {
    s_ = x_.cwiseProduct(scaling_.velocity);
    return s_;
  }
  void follow(double kappa) override {
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const Local<D> w = w_.segment<D>(c * D);
      held_[c] += kappa * (friction_speed<D>(w, friction_of<D>(scaling_, c)) - held_[c]);
    }
  }
  /// Radii of the map kHeldDisk: those of the friction disks at x. Returns the norms of their
  /// change and of the radii; with rolling friction those of s_n.
  std::pair<double, double> hold_disks() {
    double change2 = 0, size2 = 0;
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const double radius = (D.rolls ? 1 : scaling_.mu[c]) * std::max(x_[c * D], 0.0);
      change2 += (radius - held_[c]) * (radius - held_[c]);
      size2 += radius * radius;
      held_[c] = radius;
    }
    return {std::sqrt(change2), std::sqrt(size2)};
  }
  /// Natural map of the problem in which sigma or the radii are held, Σ ½ |x - P(x - w)|² [J].
  template <GradientMap kMap>
  double held_residual() const {
    double sum = 0;
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const Local<D> x = x_.segment<D>(c * D);
      const Local<D> w = w_.segment<D>(c * D);
      sum += (x - corrected<D, kMap>(x, w, friction_of<D>(scaling_, c), held_[c], 1)).squaredNorm();
    }
    return sum / 2;
  }
  void advance(int iterations, Control& control) override {
    for (; iterations > 0; --iterations) {
      const double rho = control.step / control.lambda;
      const Progress progress = project(control.map, rho);
      const double t = progress.turn > 0 ? 1 : control.t;
      control.t = next_momentum(t);
      extrapolate((t - 1) / control.t);
      if (progress.energy > control.lambda * progress.change2) {
        // The estimate of the largest eigenvalue was too small.
        control.lambda = kSpectralMargin * progress.energy / progress.change2;
        extrapolate(0);
        control.t = 1;
      }
    }
  }

 private:
  using Sum = typename Space::Sum;

  Progress project(GradientMap map, double rho) {
    if (map == GradientMap::kSplit) return project<GradientMap::kSplit>(rho);
    return map == GradientMap::kFollowed ? project<GradientMap::kFollowed>(rho)
                                         : project<GradientMap::kHeldDisk>(rho);
  }
  template <GradientMap kMap>
  Progress project(double rho) {
    Sum turn{}, change2{}, energy{};
    before_.swap(x_);
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const Local<D> y = y_.segment<D>(c * D);
      const Local<D> w = w_y_.segment<D>(c * D);
      const Local<D> x = corrected<D, kMap>(y, w, friction_of<D>(scaling_, c), held_[c], rho);
      const Local<D> change = x - before_.segment<D>(c * D);
      turn += (y - x).dot(change);
      change2 += change.squaredNorm();
      x_.segment<D>(c * D) = x;
    }
    w_before_.swap(w_);
    s_ = x_.cwiseProduct(scaling_.velocity);
    space_.velocity(s_, w_);
    w_.array() *= scaling_.velocity.array();
    space_.add_dot(x_ - before_, w_ - w_before_, energy);
    return space_.total(turn, change2, energy);
  }
  void extrapolate(double beta) {
    y_ = x_ + beta * (x_ - before_);
    w_y_ = w_ + beta * (w_ - w_before_);
  }

  const ContactProblem& p_;
  Space& space_;
  const ContactScaling& scaling_;
  Vector s_, x_, before_, y_, w_, w_before_, w_y_;
  Vector held_;  // sigma, or radii
};

/// The Space of a GradientIteration with sums in double precision, taken by process.
struct SpaceSums {
  ContactSpace& space;

  using Sum = double;
  void velocity(const Vector& s, Vector& u) { space.velocity(s, u); }
  template <class A, class B>
  void add_dot(const A& a, const B& b, Sum& sum) const {
    sum += a.dot(b);
  }
  GradientKernel::Progress total(Sum turn, Sum change2, Sum energy) {
    double values[3] = {turn, change2, energy};
    space.sum(values);
    return {values[0], values[1], values[2]};
  }
};

/// The map in use. With the choice "auto", `split` is replaced by `followed` when it stagnates.
class MapSchedule {
 public:
  /// `choice`: auto, split or followed.
  explicit MapSchedule(const std::string& choice)
      : auto_(choice == "auto"),
        map_(choice == "followed" ? GradientMap::kFollowed : GradientMap::kSplit) {}

  GradientMap map() const { return map_; }

  /// Records the best error so far. True if the map changes: return to the best iterate.
  bool advance(int iteration, double best_error) {
    if (!auto_ || map_ != GradientMap::kSplit) return false;
    if (!stagnation_.stagnates(iteration, best_error)) return false;
    map_ = GradientMap::kFollowed;
    return true;
  }

 private:
  bool auto_;
  GradientMap map_;
  StagnationTest stagnation_{1000};
};

/// Largest number of iterations between two looks at the clock.
inline constexpr int kUnwatchedSteps = 64;
/// Number of iterations after which the steps of sigma are damped.
inline constexpr int kFollowDamped = 1600;

/// Iterates until the monitor stops it. `hold`: iterations between two steps of sigma. The map
/// `followed` takes its first sigma from the velocity of a start that is not 0.
inline void iterate_gradient(GradientKernel& kernel, MapSchedule schedule, int hold, double lambda,
                             double step, SolveRun& run) {
  const Vector start = run.start();
  kernel.reset(start);
  if (schedule.map() == GradientMap::kFollowed && run.space().any(!start.isZero(0))) {
    kernel.follow(1);
  }
  GradientKernel::Control control{.lambda = lambda, .step = step, .map = schedule.map()};
  int since = 0;  // iterations with the present map
  // A step of sigma after the last iteration; before it, since the last judgement.
  bool stepped = false, changed = true;
  for (int iteration = 0;;) {
    if (run.due(iteration)) {
      // While sigma is held, an impulse that stands will move later.
      const bool moving = control.map == GradientMap::kFollowed && !changed;
      if (run.stop(iteration, kernel.impulse(), step / control.lambda, moving)) return;
      changed = false;
      if (schedule.advance(iteration, run.best_error())) {
        kernel.reset(run.best_impulse());
        control.t = 1;
        control.map = schedule.map();
        since = 0;
      }
    }
    const bool follows = control.map == GradientMap::kFollowed;
    const int most = follows ? std::min(hold - since % hold, kUnwatchedSteps) : kUnwatchedSteps;
    const int count = run.undue(iteration, most);
    kernel.advance(count, control);
    iteration += count;
    since += count;
    changed = changed || stepped;
    stepped = follows && since % hold == 0;
    if (stepped) kernel.follow(std::min(1.0, static_cast<double>(kFollowDamped) / since));
  }
}

}  // namespace bipot
