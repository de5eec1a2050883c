#include "solvers/methods/multistart_newton.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <random>

#include "solvers/kernels/contact_scaling.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

// Steps without a better error after which a start is left.
constexpr int kPatience = 10;
constexpr int kPolish = 4;
// Singular values below this, relative to the largest, are zeros: W of a hyperstatic packing.
constexpr double kRankTolerance = 1e-14;

/// The equations of the class comment at x, in the variables x_t and max(1, mu) x_n.
template <int D>
class AlartCurnierStep {
 public:
  AlartCurnierStep(const ContactProblem& p, const ContactScaling& scaling, double unit)
      : contacts_(p.num_contacts()),
        W_(Eigen::MatrixXd::Zero(p.num_rows(), p.num_rows())),
        b_(p.u_free.cwiseProduct(scaling.velocity) / unit),
        mu_(D == 1 ? Vector::Zero(p.num_contacts()) : scaling.mu),
        column_(Vector::Ones(p.num_rows())) {
    for (int i = 0; i < p.num_rows(); ++i) {
      for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
        W_(i, it.col()) = it.value() * scaling.velocity[i] / scaling.impulse[it.col()];
      }
    }
    for (int c = 0; c < contacts_; ++c) column_[c * D] = 1 / std::max(1.0, mu_[c]);
  }

  /// Length of the normal unknown's unit: x_n = column * unknown.
  const Vector& column() const { return column_; }

  /// x after one step; false where it is not finite.
  bool operator()(Vector& x) {
    w_.noalias() = W_ * x + b_;
    jacobian_.setZero(x.size(), x.size());
    residual_.setZero(x.size());
    for (int c = 0; c < contacts_; ++c) contact(c, x);
    jacobian_ = jacobian_ * column_.asDiagonal();
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double largest = jacobian_.row(i).cwiseAbs().maxCoeff();
      if (!(largest > 0)) continue;
      jacobian_.row(i) /= largest;
      residual_[i] /= largest;
    }
    if (!jacobian_.allFinite() || !residual_.allFinite()) return false;
    least_squares_.setThreshold(kRankTolerance);
    least_squares_.compute(jacobian_);
    x -= column_.cwiseProduct(Vector(least_squares_.solve(residual_)));
    return x.allFinite();
  }

 private:
  /// Rows of one contact.
  void contact(int c, const Vector& x) {
    const int n = c * D;
    if (x[n] - w_[n] * column_[n] <= 0) {
      for (int k = n; k < n + D; ++k) equal(k, x[k]);
      return;
    }
    vanishing(n);
    if constexpr (D > 1) {
      using Tangent = Eigen::Matrix<double, D - 1, 1>;
      using Block = Eigen::Matrix<double, D - 1, D - 1>;
      const Tangent target = x.template segment<D - 1>(n + 1) - w_.template segment<D - 1>(n + 1);
      const double norm = target.norm(), radius = mu_[c] * x[n];
      if (norm <= radius) {
        for (int k = n + 1; k < n + D; ++k) vanishing(k);
        return;
      }
      // x_t - radius e(x_t - w_t), whose direction turns by (I - e e^T)/norm.
      const Tangent e = target / norm;
      const Block turn = (radius / norm) * (Block::Identity() - e * e.transpose());
      residual_.template segment<D - 1>(n + 1) = x.template segment<D - 1>(n + 1) - radius * e;
      auto rows = jacobian_.template middleRows<D - 1>(n + 1);
      rows.noalias() = turn * W_.template middleRows<D - 1>(n + 1);
      rows.template middleCols<D - 1>(n + 1) += Block::Identity() - turn;
      rows.col(n) -= mu_[c] * e;
    }
  }
  void equal(int row, double value) {
    residual_[row] = value;
    jacobian_(row, row) = 1;
  }
  void vanishing(int row) {
    residual_[row] = w_[row];
    jacobian_.row(row) = W_.row(row);
  }

  const int contacts_;
  Eigen::MatrixXd W_;
  Vector b_, mu_, column_;
  Vector w_, residual_;
  Eigen::MatrixXd jacobian_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> least_squares_;
};

/// Entries in (-1, 1), normals positive, in the units of the step's unknowns.
Vector random_impulse(std::mt19937_64& engine, const Vector& column, int dim) {
  Vector x(column.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double value = static_cast<double>(engine() >> 11) * 0x1.0p-52 - 1;
    x[i] = column[i] * (i % dim == 0 ? std::abs(value) : value);
  }
  return x;
}

template <int D>
SolveResult solve_with(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kMultistartNewtonParameters);
  const int starts = parameters.integer("starts"), steps = parameters.integer("steps_each");
  IterationMonitor monitor(p, options);
  monitor.judge_every_iteration();
  const ContactScaling scaling = equilibrated_scaling(p, monitor.evaluator().delassus().diagonal());
  const double largest = p.u_free.cwiseProduct(scaling.velocity).cwiseAbs().maxCoeff();
  const double unit = largest > 0 ? largest : 1;
  AlartCurnierStep<D> step(p, scaling, unit);
  ContactErrorEvaluator evaluate(p);
  std::mt19937_64 engine(static_cast<std::uint64_t>(parameters.integer("seed")));
  const Vector s0 = start_of(p, options);
  monitor.end_setup();

  const auto impulse = [&](const Vector& x) -> Vector {
    return unit * x.cwiseQuotient(scaling.impulse);
  };
  // An answer costs a step or two more to have it to rounding, which large friction may need: what
  // meets the tolerance in double need not in extended precision (core/problem/extended_error.h).
  const auto polish = [&](Vector& x) {
    double error = evaluate(impulse(x)).guarded();
    for (int k = 0; k < kPolish && error <= options.tol; ++k) {
      Vector next = x;
      if (!step(next)) return;
      const double better = evaluate(impulse(next)).guarded();
      if (!(better < error)) return;
      x = next;
      error = better;
    }
  };

  int iteration = 0, start = 0;
  bool done = monitor.stop(0, s0);
  for (; start < starts && !done; ++start) {
    // The caller's impulse, then by turns one from nowhere and one in the vicinity of the best.
    Vector x = s0.cwiseProduct(scaling.impulse) / unit;
    if (start > 0) x = random_impulse(engine, step.column(), D);
    if (start > 0 && start % 2 == 0) {
      x += monitor.best_impulse().cwiseProduct(scaling.impulse) / unit;
    }
    double best = std::numeric_limits<double>::infinity();
    int since = 0;
    for (int k = 0; k < steps && since < kPatience && !done; ++k) {
      if (!step(x)) break;
      polish(x);
      // Another start changes what one step left alone: an equal impulse is no stall.
      done = monitor.stop(++iteration, impulse(x), kNaN, true);
      since = monitor.last_error() < best ? 0 : since + 1;
      best = std::min(best, monitor.last_error());
    }
    done = done || monitor.end_if_out_of_time(iteration);
  }
  if (!done) {
    monitor.end(SolveStatus::kStalled,
                fmt::format("none of {} starts arrived in {} Newton steps", starts, iteration));
  }
  SolveResult result = monitor.finish();
  result.message += fmt::format("; {} start{}", start, start == 1 ? "" : "s");
  return result;
}

}  // namespace

SolveResult solve_multistart_newton(const ContactProblem& p, const SolverOptions& options) {
  switch (p.dim) {
    case 1:
      return solve_with<1>(p, options);
    case 2:
      return solve_with<2>(p, options);
    default:
      return solve_with<3>(p, options);
  }
}

}  // namespace bipot
