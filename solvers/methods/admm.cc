#include "solvers/methods/admm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "core/problem/sparse_factor.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

constexpr int kFirstBalance = 20;          // iterations before the first change of rho
constexpr double kBalanceInterval = 0.25;  // of the iterations so far, before the next one
constexpr double kImbalance = 5;           // factor of rho below which it is left alone
constexpr double kLargestChange = 100;     // of rho at once
constexpr double kSmallestRho = 1e-3;      // of balancing; smaller ones cost digits in the solve
constexpr double kAtRest = 4e-15;          // relative change of a multiplier at rest
constexpr int kCorrections = 2;            // for the skew part of W
constexpr int kRaises = 20;                // of rho by 10, for an indefinite W

/// x = (W + rho I)⁻¹ r in the scaled variables.
class Resolvent {
 public:
  Resolvent(const ContactProblem& p, const Vector& scale) {
    if (p.has_velocities()) {
      mass_ = p.A;
      wrench_ = p.H * scale.asDiagonal();
      product_ = wrench_ * SparseMatrix(wrench_.transpose());
      return;
    }
    delassus_ = scale.asDiagonal() * p.W * scale.asDiagonal();
    const SparseMatrix transposed = delassus_.transpose();
    symmetric_ = 0.5 * (delassus_ + transposed);
    skew_ = 0.5 * (delassus_ - transposed);
    skew_.prune(0.0);
    identity_.resize(delassus_.rows(), delassus_.cols());
    identity_.setIdentity();
  }

  /// What factor() does first: callers ask their clock in between.
  void analyse(double rho) { factor_.analyse(matrix(rho)); }
  bool factor(double rho) {
    rho_ = rho;
    return factor_.factor(matrix(rho));
  }

  /// x holds the start of the residual correction.
  void solve(const Vector& r, Vector& x) {
    if (through_velocities()) {
      velocity_.noalias() = wrench_ * r;
      factor_.solve(velocity_, velocity_);
      x.noalias() = wrench_.transpose() * velocity_;
      x = (r - x) / rho_;
    } else if (skew_.nonZeros() == 0) {
      x = factor_.solve(r);
    } else {
      for (int k = 0; k < kCorrections; ++k) x = factor_.solve(Vector(r - skew_ * x));
    }
  }

 private:
  bool through_velocities() const { return wrench_.cols() > 0; }
  SparseMatrix matrix(double rho) const {
    return through_velocities() ? SparseMatrix(product_ + rho * mass_)
                                : SparseMatrix(symmetric_ + rho * identity_);
  }

  SparseMatrix mass_, wrench_, product_;
  SparseMatrix delassus_, symmetric_, skew_, identity_;
  SparseCholesky factor_;
  Vector velocity_;
  double rho_ = 0;
};

/// False when no penalty makes the matrix positive definite, or time is over before.
bool factor_raising(Resolvent& resolvent, double& rho, Vector& y, const IterationMonitor& monitor) {
  if (!monitor.out_of_time()) resolvent.analyse(rho);
  for (int k = 0; k < kRaises && !monitor.out_of_time(); ++k) {
    if (resolvent.factor(rho)) return true;
    rho *= 10;
    y *= 0.1;
  }
  return false;
}

enum class Penalty { kStaged, kBalanced, kFixed };

/// Raises the penalty step by step while the best error does not fall.
class Stages {
 public:
  /// Factor for rho, 1 for no change; 0 when the last stage has failed too.
  double advance(int iteration, double best_error) {
    if (best_error <= 0.5 * mark_) {
      mark_ = best_error;
      mark_iteration_ = iteration;
    } else if (iteration - mark_iteration_ > kPatience) {
      mark_iteration_ = iteration;
      return ++raised_ <= kStages ? kRaise : 0;
    }
    return 1;
  }

 private:
  static constexpr int kPatience = 100, kStages = 6;
  static constexpr double kRaise = 3.1622776601683795;  // six of them make 1000
  double mark_ = std::numeric_limits<double>::infinity();
  int mark_iteration_ = 0, raised_ = 0;
};

template <int D>
void iterate(const ContactProblem& p, const ContactScaling& scaling, const Vector& velocity0,
             const Vector& s0, double rho, double relaxation, Penalty penalty,
             IterationMonitor& monitor) {
  Resolvent resolvent(p, scaling.velocity);
  Vector z = scaling.impulse.cwiseProduct(s0), x = z, y(z.size()), s(z.size());
  const Vector b = scaling.velocity.cwiseProduct(p.u_free);
  // Start of the multiplier: minus de Saxcé's velocity at s0, where that is not 0.
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Local<D> w =
        velocity0.segment<D>(c * D).cwiseProduct(Local<D>(scaling.velocity.segment<D>(c * D)));
    y.segment<D>(c * D) = -de_saxce_velocity<D>(w, scaling.mu[c]) / rho;
  }
  if (s0.isZero(0)) y.setZero();
  if (!factor_raising(resolvent, rho, y, monitor)) {
    if (!monitor.end_if_out_of_time(0)) {
      monitor.end(SolveStatus::kNumericalFailure, "W + rho I is not positive definite");
    }
    return;
  }
  monitor.end_setup();
  Vector rhs(z.size()), z_before, y_judged = Vector::Zero(z.size());
  int next_balance = kFirstBalance;
  Stages stages;
  for (int iteration = 0;; ++iteration) {
    if (monitor.due(iteration)) {
      s = z.cwiseProduct(scaling.velocity);
      // A multiplier that still moves will move s later.
      const bool moving = (y - y_judged).norm() > kAtRest * y.norm();
      if (monitor.stop(iteration, s, rho, moving)) return;
      y_judged = y;
    }
    rhs = rho * (z - y) - b;
    if constexpr (D > 1) {
      for (int c = 0; c < p.num_contacts(); ++c) {
        const Local<D> multiplier = y.segment<D>(c * D);
        rhs[c * D] -= scaling.mu[c] * rho * tangential_norm<D>(multiplier);
      }
    }
    resolvent.solve(rhs, x);
    z_before = z;
    for (int c = 0; c < p.num_contacts(); ++c) {
      const Local<D> relaxed = relaxation * x.segment<D>(c * D) +
                               (1 - relaxation) * z_before.segment<D>(c * D) + y.segment<D>(c * D);
      const Local<D> projected = project_coulomb_cone<D>(relaxed, scaling.mu[c]);
      z.segment<D>(c * D) = projected;
      y.segment<D>(c * D) = relaxed - projected;
    }
    double factor = 1;
    if (penalty == Penalty::kStaged) {
      if (monitor.due(iteration + 1)) {
        factor = stages.advance(iteration + 1, monitor.best_error());
        if (factor == 0) {
          penalty = Penalty::kBalanced;
          factor = 1;
        }
      }
    } else if (penalty == Penalty::kBalanced && iteration + 1 >= next_balance) {
      const double primal = (x - z).norm() / std::max(x.norm(), z.norm());
      const double dual = (z - z_before).norm() / y.norm();
      const double wanted = std::sqrt(primal / dual);
      if (wanted > kImbalance || wanted < 1 / kImbalance) {
        factor = std::clamp(wanted, 1 / kLargestChange, kLargestChange);
        factor = std::clamp(rho * factor, kSmallestRho, 1 / kSmallestRho) / rho;
      }
      next_balance =
          iteration + 1 + std::max(kFirstBalance, static_cast<int>(kBalanceInterval * iteration));
    }
    if (factor != 1) {
      rho *= factor;
      y /= factor;
      if (!factor_raising(resolvent, rho, y, monitor)) {
        if (!monitor.end_if_out_of_time(iteration + 1)) {
          monitor.end(SolveStatus::kNumericalFailure,
                      fmt::format("factorisation failed for rho = {:.2e}", rho));
        }
        return;
      }
    }
  }
}

}  // namespace

SolveResult solve_admm(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kAdmmParameters);
  IterationMonitor monitor(p, options);
  const DelassusOperator& delassus = monitor.evaluator().delassus();
  const ContactScaling scaling = equilibrated_scaling(p, delassus.diagonal());
  const Vector s0 = start_of(p, options);
  Vector velocity(p.num_rows());
  delassus.velocity(s0, velocity);
  const std::string rule = parameters.choice("penalty");
  const Penalty penalty = rule == "staged"     ? Penalty::kStaged
                          : rule == "balanced" ? Penalty::kBalanced
                                               : Penalty::kFixed;
  dispatch_dim(p.dim, [&](auto d) {
    iterate<d()>(p, scaling, velocity, s0, parameters.number("rho"),
                 parameters.number("relaxation"), penalty, monitor);
  });
  return monitor.finish();
}

}  // namespace bipot
