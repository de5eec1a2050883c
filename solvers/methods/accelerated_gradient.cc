#include "solvers/methods/accelerated_gradient.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "core/problem/disk_structure.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/spectral_estimate.h"
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

/// The iteration through the Delassus operator, any problem.
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

 private:
  const ContactProblem& p_;
  const DelassusOperator& delassus_;
  const ContactScaling& scaling_;
  Vector s_, x_, before_, y_, w_, w_before_, w_y_;
};

/// The same for disks, one pass over the contacts: the velocity at the extrapolated point comes
/// from the extrapolated momenta of the bodies, and x⁺ is scattered to the next momenta at once.
template <int D>
class DiskKernel {
 public:
  DiskKernel(const ContactProblem& p, const DiskStructure& disks, const ContactScaling& scaling)
      : scaling_(scaling),
        bodies_(disks.bodies),
        contacts_(to_size(p.num_contacts())),
        velocity_(4 * bodies_.size()),
        momentum_{std::vector<double>(4 * bodies_.size()), std::vector<double>(4 * bodies_.size())},
        s_(p.num_rows()) {
    for (int c = 0; c < p.num_contacts(); ++c) {
      const DiskStructure::Contact& from = disks.contacts[to_size(c)];
      Contact& to = contacts_[to_size(c)];
      to.i = 4 * from.i;
      to.j = 4 * from.j;
      const double normal = from.normal * scaling.velocity[c * D];
      to.gx = normal * from.n[0];
      to.gy = normal * from.n[1];
      if constexpr (D == 2) {
        to.spin = from.tangential * scaling.velocity[c * D + 1];
        to.ratio = to.spin / normal;
      }
      to.mu = scaling.mu[c];
      to.cone = 1 / (1 + to.mu * to.mu);
      for (int k = 0; k < D; ++k) to.b[k] = scaling.velocity[c * D + k] * p.u_free[c * D + k];
    }
  }

  void reset(const Vector& s) {
    now_ = 0;
    std::fill(momentum_[0].begin(), momentum_[0].end(), 0.0);
    for (Contact& c : contacts_) {
      const Eigen::Index row = D * (&c - contacts_.data());
      for (int k = 0; k < D; ++k) c.x[0][k] = c.x[1][k] = scaling_.impulse[row + k] * s[row + k];
      scatter(c, c.x[0], momentum_[0].data());
    }
    momentum_[1] = momentum_[0];
    extrapolate(0);
  }
  const Vector& impulse() {
    for (const Contact& c : contacts_) {
      const Eigen::Index row = D * (&c - contacts_.data());
      for (int k = 0; k < D; ++k) s_[row + k] = c.x[now_][k] * scaling_.velocity[row + k];
    }
    return s_;
  }
  template <Map kMap>
  Progress project(double rho) {
    double turn = 0, change2 = 0;
    const int now = now_, next = 1 - now_;
    const double beta = beta_;
    const double* const velocity = velocity_.data();
    double* const momentum = momentum_[next].data();
    for (Contact& c : contacts_) {
      const double* const vi = velocity + c.i;
      const double* const vj = velocity + c.j;
      const double vx = vi[0] - vj[0], vy = vi[1] - vj[1];
      double wn = c.gx * vx + c.gy * vy + c.b[0];
      const double xn = c.x[now][0];
      const double yn = xn + beta * (xn - c.x[next][0]);
      double zn = 0;
      if constexpr (D == 1) {
        zn = positive_part(yn - rho * wn);
      } else {
        const double wt = c.ratio * (c.gx * vy - c.gy * vx) - c.spin * (vi[2] + vj[2]) + c.b[1];
        const double xt = c.x[now][1];
        const double yt = xt + beta * (xt - c.x[next][1]);
        const double tau_t = yt - rho * wt;
        if constexpr (kMap == Map::kCone) {
          const double tau_n = yn - rho * (wn + c.mu * std::abs(wt));
          const double edge = (tau_n + c.mu * std::abs(tau_t)) * c.cone;
          zn = positive_part(edge > tau_n ? edge : tau_n);
        } else {
          zn = positive_part(yn - rho * wn);
        }
        const double zt = cut_off(tau_t, c.mu * zn);
        const double change = zt - xt;
        turn += (yt - zt) * change;
        change2 += change * change;
        c.x[next][1] = zt;
      }
      const double change = zn - xn;
      turn += (yn - zn) * change;
      change2 += change * change;
      c.x[next][0] = zn;
      scatter(c, c.x[next], momentum);
    }
    now_ = next;
    return {turn, change2};
  }
  double extrapolate(double beta) {
    beta_ = beta;
    double energy = 0;
    const double* now = momentum_[now_].data();
    double* before = momentum_[1 - now_].data();  // becomes the accumulator of project()
    double* v = velocity_.data();
    for (const DiskStructure::Body& body : bodies_) {
      const double inverse[3] = {body.inverse_mass, body.inverse_mass, body.inverse_inertia};
      for (int k = 0; k < 3; ++k) {
        const double change = now[k] - before[k];
        energy += inverse[k] * change * change;
        v[k] = inverse[k] * (now[k] + beta * change);
        before[k] = 0;
      }
      now += 4;
      before += 4;
      v += 4;
    }
    return energy;
  }

 private:
  static constexpr std::size_t kRows = D;
  struct Contact {
    int i = 0, j = 0;  // offsets of the bodies' values
    double gx = 0, gy = 0, ratio = 0, spin = 0, mu = 0;
    double cone = 0;  // 1/(1 + mu²)
    double b[kRows] = {};
    double x[2][kRows] = {};  // the iterate and the one before
  };

  static void scatter(const Contact& c, const double* x, double* momentum) {
    double* const pi = momentum + c.i;
    double* const pj = momentum + c.j;
    double px = c.gx * x[0], py = c.gy * x[0];
    if constexpr (D == 2) {
      const double tangential = c.ratio * x[1], spin = c.spin * x[1];
      px -= c.gy * tangential;
      py += c.gx * tangential;
      pi[2] -= spin;
      pj[2] -= spin;
    }
    pi[0] += px;
    pi[1] += py;
    pj[0] -= px;
    pj[1] -= py;
  }

  const ContactScaling& scaling_;
  std::vector<DiskStructure::Body> bodies_;
  std::vector<Contact> contacts_;
  std::vector<double> velocity_;     // at the extrapolated point: (x, y, a ω, padding) a body
  std::vector<double> momentum_[2];  // of the iterate and of the one before, likewise
  Vector s_;
  int now_ = 0;
  double beta_ = 0;
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

template <class Kernel>
void iterate(Kernel kernel, MapRota rota, const Vector& s0, double lambda, double step,
             IterationMonitor& monitor) {
  kernel.reset(s0);
  double t = 1;
  for (int iteration = 0;; ++iteration) {
    if (monitor.due(iteration)) {
      if (monitor.stop(iteration, kernel.impulse(), step / lambda)) return;
      if (rota.advance(iteration, monitor.best_error())) {
        kernel.reset(monitor.best_impulse());
        t = 1;
      }
    }
    const double rho = step / lambda;
    const Progress progress = rota.map() == Map::kCone ? kernel.template project<Map::kCone>(rho)
                                                       : kernel.template project<Map::kSplit>(rho);
    if (progress.turn > 0 || !rota.momentum()) t = 1;
    const double t_next = 0.5 * (1 + std::sqrt(1 + 4 * t * t));
    const double energy = kernel.extrapolate((t - 1) / t_next);
    t = t_next;
    if (energy > lambda * progress.change2) {
      // A larger eigenvalue than the estimate has shown itself.
      lambda = kSpectralMargin * energy / progress.change2;
      kernel.extrapolate(0);
      t = 1;
    }
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
        iterate(DiskKernel<D>(p, *delassus.disks(), scaling), rota, s0, lambda, step, monitor);
        return;
      }
    }
    iterate(GeneralKernel<D>(p, delassus, scaling), rota, s0, lambda, step, monitor);
  });
  return monitor.finish();
}

}  // namespace bipot
