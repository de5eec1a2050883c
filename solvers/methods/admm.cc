#include "solvers/methods/admm.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/linear/frontal_cholesky.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "solvers/kernels/contact_penalties.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/solve_run.h"
#include "solvers/systems/body_columns.h"

namespace bipot {
namespace {

constexpr int kFirstBalance = 20;          // iterations before the first change of rho
constexpr double kBalanceInterval = 0.25;  // of the iterations so far, before the next one
constexpr double kImbalance = 5;           // factor of rho below which it does not change
constexpr double kLargestChange = 100;     // of rho at once
constexpr double kSmallestRho = 1e-3;      // of balancing; smaller ones lose digits in the solve
constexpr double kAtRest = 4e-15;          // relative change of a multiplier at rest
constexpr int kCorrections = 2;            // for the skew part of W
constexpr int kRaises = 20;                // of rho by 10, for an indefinite W
// Iterations between two observations of the statuses, observations between two changes of their
// penalties.
constexpr int kLook = 25, kLooks = 3;
// Schedule of raising rho: number of iterations without halving the error before a raise, the total
// factor, the factor of the last raises with their longer wait, and the wait before the rule ends.
constexpr int kRaisePatience = 70, kLastPatience = 600, kEndPatience = 2000;
constexpr double kRaisedBy = 300, kLastRaises = 5;
constexpr double kOverRelaxation = 1.6;

/// x = (W + M)⁻¹ r in the scaled variables, M the penalties.
template <ContactRows D>
class Resolvent {
 public:
  Resolvent(const ContactProblem& p, const Vector& scale, FactorStop stop) : rows_(p.num_rows()) {
    factor_.stop_by(std::move(stop));
    if (p.has_velocities()) {
      body_.emplace(p, scale);
      velocity_ = Vector::Zero(p.num_dofs());
      residual_ = velocity_;
      u_ = Vector::Zero(rows_);
      return;
    }
    delassus_ = scale.asDiagonal() * p.W * scale.asDiagonal();
    const SparseMatrix transposed = delassus_.transpose();
    symmetric_ = 0.5 * (delassus_ + transposed);
    skew_ = 0.5 * (delassus_ - transposed);
    skew_.prune(0.0);
  }

  /// First part of factor(): callers check their clock in between.
  void analyse(const ContactPenalties<D>& penalties) {
    if (!body_) return factor_.analyse(shifted(penalties));
    if (!analysed_) factor_.analyse(body_->pattern());
    analysed_ = true;
  }
  bool factor(const ContactPenalties<D>& penalties) {
    if (!body_) return factor_.factor(shifted(penalties));
    const auto add = [&](int column, const FrontalCholesky::Column& to) {
      body_->add(column, penalties.inverses(), to);
    };
    return factor_.factor(add, body_->diagonal());
  }

  /// x: an approximation, the last one, which is corrected by its residual. The factor is in single
  /// precision and without the skew part of W: what is left vanishes as the iteration converges.
  void solve(const ContactPenalties<D>& penalties, const Vector& r, Vector& x) {
    if (body_) {
      const auto impulses = [&] {
        for (int c = 0; c * D < rows_; ++c) {
          x.segment<D>(c * D) = penalties.inverse(c) * (r.segment<D>(c * D) - u_.segment<D>(c * D));
        }
      };
      impulses();
      body_->residual(x, velocity_, residual_);
      factor_.solve(residual_, residual_);
      velocity_ += residual_;
      for (int c = 0; c * D < rows_; ++c) {
        u_.segment<D>(c * D) = body_->template velocity<D>(c, velocity_);
      }
      impulses();
      return;
    }
    const int corrections = skew_.nonZeros() == 0 ? 1 : kCorrections;
    for (int k = 0; k < corrections; ++k) {
      residual_ = r;
      residual_.noalias() -= delassus_ * x;
      for (int c = 0; c * D < rows_; ++c) {
        residual_.segment<D>(c * D) -= penalties.times(c, x.segment<D>(c * D));
      }
      factor_.solve(residual_, residual_);
      x += residual_;
    }
  }

 private:
  /// Blocks are whole, zeros included, so that one analysis serves all.
  const SparseMatrix& shifted(const ContactPenalties<D>& penalties) {
    SparseMatrix blocks(rows_, rows_);
    blocks.reserve(Eigen::VectorXi::Constant(rows_, D));
    for (int c = 0; c * D < rows_; ++c) {
      for (int column = 0; column < D; ++column) {
        for (int row = 0; row < D; ++row) {
          blocks.insert(c * D + row, c * D + column) = penalties.metric(c)(row, column);
        }
      }
    }
    shifted_ = symmetric_ + blocks;
    return shifted_;
  }

  int rows_;
  std::optional<BodyColumns> body_;  // of problems with velocities
  bool analysed_ = false;            // its pattern
  SparseMatrix delassus_, symmetric_, skew_, shifted_;
  FrontalCholesky factor_;
  Vector velocity_, u_;  // of bodies and contacts, the latter scaled
  Vector residual_;
};

/// False if no penalty makes the matrix positive definite, or the time is over.
template <ContactRows D>
bool factor_raising(Resolvent<D>& resolvent, ContactPenalties<D>& penalties, Vector& y,
                    SolveRun& run) {
  if (!run.out_of_time()) resolvent.analyse(penalties);
  for (int k = 0; k < kRaises && !run.out_of_time(); ++k) {
    if (resolvent.factor(penalties)) return true;
    penalties.scale(10);
    y *= 0.1;
  }
  return false;
}

/// Raises the penalty step by step while the best error does not decrease.
class Stages {
 public:
  /// Factor for rho, 1 for no change; 0 if the last stage has failed too.
  double advance(int iteration, double best_error) {
    if (best_error <= 0.5 * mark_) {
      mark_ = best_error;
      mark_iteration_ = iteration;
      return 1;
    }
    const bool end = left_ <= 1 + kRounding;
    const int patience = end ? kEndPatience : left_ > kLastRaises ? kRaisePatience : kLastPatience;
    if (iteration - mark_iteration_ <= patience) return 1;
    mark_iteration_ = iteration;
    if (end) return 0;
    const double raise = std::min(kRaise, left_);
    left_ /= raise;
    return raise;
  }

 private:
  static constexpr double kRaise = 3.1622776601683795, kRounding = 1e-9;
  double left_ = kRaisedBy;
  double mark_ = kInfinity;
  int mark_iteration_ = 0;
};

template <ContactRows D>
void iterate(const ContactProblem& p, ContactScaling scaling, Vector velocity0, Vector s0,
             double rho, SolveRun& run) {
  Resolvent<D> resolvent(p, scaling.velocity, run.factor_stop());
  std::vector<FrictionOf<D>> friction;
  for (int c = 0; c < p.num_contacts(); ++c) friction.push_back(friction_of<D>(scaling, c));
  ContactPenalties<D> penalties(std::move(friction), rho);
  Vector z = scaling.impulse.cwiseProduct(s0), x = z, y(z.size());
  // Start of the multiplier: minus de Saxcé's velocity at s0, less of it where it would move z by
  // more than its own size. What that leaves in the kernel of W never decays.
  double jump = 0;  // squared
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Local<D> start = z.segment<D>(c * D);
    const Local<D> w =
        velocity0.segment<D>(c * D).cwiseProduct(Local<D>(scaling.velocity.segment<D>(c * D)));
    const Local<D> multiplier = -de_saxce_velocity<D>(w, friction_of<D>(scaling, c)) / rho;
    y.segment<D>(c * D) = multiplier;
    jump += (penalties.project(c, start + multiplier) - start).squaredNorm();
  }
  if (jump > 0) y *= std::min(1.0, z.norm() / std::sqrt(jump));
  for (Vector* start : {&velocity0, &s0, &scaling.impulse}) start->resize(0);
  const auto factor = [&](int iteration) {
    if (factor_raising(resolvent, penalties, y, run)) return true;
    if (!run.end_if_out_of_time(iteration)) {
      run.end(SolveStatus::kNumericalFailure,
              fmt::format("factorisation failed up to rho = {:.2e}", penalties.rho()));
    }
    return false;
  };
  if (!factor(0)) return;
  run.end_setup();
  Vector rhs(z.size()), z_before, y_judged = Vector::Zero(z.size());
  int next_balance = kFirstBalance;
  Stages stages;
  bool balanced = false;  // one rho for all, by residuals
  for (int iteration = 0;; ++iteration) {
    if (run.due(iteration)) {
      rhs = z.cwiseProduct(scaling.velocity);
      // A multiplier that still changes will change s later.
      const bool moving = (y - y_judged).norm() > kAtRest * y.norm();
      if (run.stop(iteration, rhs, penalties.rho(), moving)) return;
      y_judged = y;
    }
    for (int c = 0; c < p.num_contacts(); ++c) {
      const Local<D> multiplier = penalties.times(c, y.segment<D>(c * D));
      Local<D> r = penalties.times(c, z.segment<D>(c * D)) - multiplier;
      if constexpr (D > 1) r[0] -= friction_speed<D>(multiplier, friction_of<D>(scaling, c));
      rhs.segment<D>(c * D) =
          r - scaling.velocity.segment<D>(c * D).cwiseProduct(p.u_free.segment<D>(c * D));
    }
    resolvent.solve(penalties, rhs, x);
    if (balanced) z_before = z;
    for (int c = 0; c < p.num_contacts(); ++c) {
      const Local<D> relaxed = kOverRelaxation * x.segment<D>(c * D) +
                               (1 - kOverRelaxation) * z.segment<D>(c * D) + y.segment<D>(c * D);
      const Local<D> projected = penalties.project(c, relaxed);
      z.segment<D>(c * D) = projected;
      y.segment<D>(c * D) = relaxed - projected;
    }
    double change = 1;
    bool adapts = false, refactors = false;
    if (!balanced && (iteration + 1) % kLook == 0) {
      penalties.observe(z);
      adapts = (iteration + 1) % (kLook * kLooks) == 0;
    }
    if (adapts) {
      change = stages.advance(iteration + 1, run.best_error());
      if (change == 0) {
        penalties.equalise(y);
        refactors = balanced = true;
        adapts = false;
        change = 1;
      }
    } else if (balanced && iteration + 1 >= next_balance) {
      const double primal = (x - z).norm() / std::max(x.norm(), z.norm());
      const double dual = (z - z_before).norm() / y.norm();
      const double wanted = std::sqrt(primal / dual);
      if (wanted > kImbalance || wanted < 1 / kImbalance) {
        change = std::clamp(wanted, 1 / kLargestChange, kLargestChange);
        change =
            std::clamp(penalties.rho() * change, kSmallestRho, 1 / kSmallestRho) / penalties.rho();
      }
      next_balance =
          iteration + 1 + std::max(kFirstBalance, static_cast<int>(kBalanceInterval * iteration));
    }
    if (change != 1) {
      penalties.scale(change);
      y /= change;
    }
    if (adapts) penalties.adapt(y);
    if ((change != 1 || adapts || refactors) && !factor(iteration + 1)) return;
  }
}

}  // namespace

void solve_admm(SolveRun& run) {
  const Parameters& parameters = run.parameters();
  const ContactProblem& p = run.problem();
  const DelassusOperator& delassus = run.delassus();
  ContactScaling scaling = equilibrated_scaling(p, delassus.diagonal());
  Vector s0 = run.start();
  Vector velocity(p.num_rows());
  delassus.velocity(s0, velocity);
  dispatch_rows(p, [&](auto d) {
    iterate<d()>(p, std::move(scaling), std::move(velocity), std::move(s0),
                 parameters.number("rho"), run);
  });
}

}  // namespace bipot
