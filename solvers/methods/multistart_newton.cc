#include "solvers/methods/multistart_newton.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/portable_random.h"
#include "core/criterion/extended_error.h"
#include "core/linear/dense_factor.h"
#include "core/problem/delassus.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/registry.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

// Gauss-Seidel sweeps before the first start, for packings at rest: no Newton step finds their many
// statuses on the edge.
constexpr int kSweeps = 1000;
// Number of steps without fewer contradictions after which a start is given up.
constexpr int kPatience = 10;
// First steps of a start: all statuses follow.
constexpr int kWholeSteps = 6;
// Probability that a status that contradicts its contact changes in later steps: pure steps end in
// cycles.
constexpr double kShare = 0.3;
// Share of contacts drawn again in every other start, which begins at the best impulse so far.
constexpr double kRedrawn = 0.15;
constexpr int kPolish = 4;
// At large friction, iterates with an error of up to this many tolerances may be answers but for
// rounding, which is then reduced.
constexpr double kNearlyThere = 10;
constexpr int kCancellations = 20;
// From this friction on, the rounding of a single impulse may keep an answer from the tolerance.
constexpr double kLargeFriction = 1e4;
constexpr int kRounds = 10;
// An impulse of more than this many times the energy of the free violation comes from a singular
// step.
constexpr double kWild = 1e16;
// Singular values below this, relative to the largest, count as zero: W of a hyperstatic packing.
constexpr double kRankTolerance = 1e-14;

/// The equations of the class comment in the unknowns y_t = x_t and y_n = max(1, mu) x_n. At most a
/// hundred contacts: the contact dimension stays a variable, and one text serves all.
class StatusNewton {
 public:
  StatusNewton(const ContactProblem& p, const ContactScaling& scaling, double unit)
      : dim_(p.dim),
        statuses_(to_size(p.num_contacts()), kStick),
        W_(Eigen::MatrixXd::Zero(p.num_rows(), p.num_rows())),
        b_(p.u_free.cwiseProduct(scaling.velocity) / unit),
        impulse_(unit * scaling.impulse.cwiseInverse()) {
    const int tangents = p.plain_dim() - 1;
    if (tangents > 0) parts_.push_back({1, tangents, scaling.mu});
    if (p.rolls()) parts_.push_back({1 + tangents, tangents, scaling.mu_r});
    if (p.dim == 6) parts_.push_back({5, 1, scaling.mu_spin});
    for (int c = 0; c < p.num_contacts(); ++c) {
      double count = 1;
      for (const Part& part : parts_) count = std::max(count, part.bound[c]);
      for (Part& part : parts_) part.bound[c] /= count;
      impulse_[c * dim_] /= count;
    }
    for (int i = 0; i < p.num_rows(); ++i) {
      for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
        W_(i, it.col()) = it.value() * scaling.velocity[i] * impulse_[it.col()] / unit;
      }
    }
  }

  Vector impulse(const Vector& y) const { return impulse_.cwiseProduct(y); }
  Vector unknowns(const Vector& s) const { return s.cwiseQuotient(impulse_); }

  /// Changes the statuses as y requires, each with probability `share`. Returns the number of
  /// contacts that require another one.
  int update(const Vector& y, double share, PortableRandom& random) {
    w_.noalias() = W_ * y + b_;
    int contradictions = 0;
    for (std::size_t c = 0; c < statuses_.size(); ++c) {
      const int wanted = status_at(static_cast<int>(c), y);
      if (wanted == statuses_[c]) continue;
      ++contradictions;
      if (share >= 1 || random.uniform() < share) statuses_[c] = wanted;
    }
    return contradictions;
  }

  /// y after one step with the present statuses; false if it is not finite.
  bool step(Vector& y) {
    closed_.clear();
    for (std::size_t c = 0; c < statuses_.size(); ++c) {
      for (int row = static_cast<int>(c) * dim_, k = 0; k < dim_; ++k, ++row) {
        if (statuses_[c] == kOpen) {
          y[row] = 0;
        } else {
          closed_.push_back(row);
        }
      }
    }
    if (closed_.empty()) return true;
    w_.noalias() = W_ * y + b_;
    residual_ = w_(closed_);
    jacobian_ = W_(closed_, closed_);
    for (int at = 0; at < static_cast<int>(closed_.size()); at += dim_) {
      const int contact = closed_[to_size(at)] / dim_;
      for (std::size_t k = 0; k < parts_.size(); ++k) {
        if ((statuses_[to_size(contact)] >> k & 1) != 0) slip(parts_[k], contact, at, y);
      }
    }
    for (Eigen::Index i = 0; i < residual_.size(); ++i) {
      const double largest = jacobian_.row(i).cwiseAbs().maxCoeff();
      if (!(largest > 0)) continue;
      jacobian_.row(i) /= largest;
      residual_[i] /= largest;
    }
    if (!jacobian_.allFinite() || !residual_.allFinite()) return false;
    y(closed_) -= least_norm_solution(jacobian_, residual_, kRankTolerance);
    return y.allFinite();
  }

 private:
  /// Rows of a contact that friction bounds by bound × y_n: tangents, rolling, spin.
  struct Part {
    int first, count;
    Vector bound;  // of each contact
  };
  // Status of a contact: open, or a bit for each part that slips; none: it sticks.
  static constexpr int kOpen = -8, kStick = 0;  // kOpen has no bit of a part

  Vector tangential(const Part& part, int n, const Vector& y) const {
    return y.segment(n + part.first, part.count) - w_.segment(n + part.first, part.count);
  }

  int status_at(int contact, const Vector& y) const {
    const int n = contact * dim_;
    if (y[n] - w_[n] <= 0) return kOpen;
    int slipping = kStick;
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      const bool sticks = tangential(parts_[k], n, y).norm() <= parts_[k].bound[contact] * y[n];
      if (!sticks) slipping |= 1 << k;
    }
    return slipping;
  }

  /// y_t - r y_n e(y_t - w_t), whose direction turns by (I - e eᵀ)/norm; the contact's rows start at
  /// `at`.
  void slip(const Part& part, int contact, int at, const Vector& y) {
    const int n = contact * dim_, tangents = part.count, first = part.first;
    Vector e = tangential(part, n, y);
    double norm = e.norm();
    if (norm > 0) {
      e /= norm;
    } else {
      e = Vector::Unit(tangents, 0);
      norm = 1;
    }
    const double length = part.bound[contact] * y[n];
    const Eigen::MatrixXd rows = jacobian_.middleRows(at + first, tangents);
    for (int i = 0; i < tangents; ++i) {
      residual_[at + first + i] = y[n + first + i] - length * e[i];
      auto row = jacobian_.row(at + first + i);
      row.setZero();
      for (int j = 0; j < tangents; ++j) {
        const double identity = i == j ? 1 : 0, turn = (length / norm) * (identity - e[i] * e[j]);
        row += turn * rows.row(j);
        row[at + first + j] += identity - turn;
      }
      row[at] -= part.bound[contact] * e[i];
    }
  }

  int dim_;
  std::vector<int> statuses_;
  std::vector<Part> parts_;
  Eigen::MatrixXd W_;
  Vector b_, impulse_;
  Vector w_, residual_;
  std::vector<int> closed_;  // rows of closed contacts
  Eigen::MatrixXd jacobian_;
};

/// y with the entries of each contact drawn again with probability `share`: in (-1, 1), normals
/// positive.
Vector redrawn(Vector y, double share, PortableRandom& random, int dim) {
  for (Eigen::Index n = 0; n < y.size(); n += dim) {
    if (share < 1 && random.uniform() >= share) continue;
    y[n] = random.uniform();
    for (Eigen::Index k = n + 1; k < n + dim; ++k) y[k] = random.symmetric();
  }
  return y;
}

/// Replaces s, entry by entry, by neighbouring doubles while that lowers the guarded error (the
/// larger one of both precisions), in at most kRounds rounds. The error of an exact answer rounded
/// to double is mu times the rounding of sliding velocities; another double for one impulse may
/// cancel it. For few contacts: a round evaluates the criterion twice for each row. Below
/// kLargeFriction s is unchanged.
void cancel_rounding(const ContactProblem& p, const SolverOptions& options,
                     ContactErrorEvaluator& evaluate, Vector& s) {
  if (!(p.mu.maxCoeff() >= kLargeFriction)) return;
  // An error not below `best` in double precision is not evaluated in extended precision.
  const auto judge = [&](const Vector& x, double best) {
    const double error = evaluate(x).guarded();
    if (!(error < best)) return error;
    return std::max(error, extended_guarded_error(p, evaluate.impulse()));
  };
  double error = judge(s, kInfinity);
  bool better = true;
  for (int round = 0; round < kRounds && better && error > options.tol; ++round) {
    better = false;
    if (options.cancelled && options.cancelled()) break;
    for (double& entry : s) {
      if (entry == 0) continue;
      for (const double towards : {-kInfinity, kInfinity}) {
        const double before = entry;
        entry = std::nextafter(before, towards);
        const double changed = judge(s, error);
        if (changed < error) {
          error = changed;
          better = true;
        } else {
          entry = before;
        }
      }
    }
  }
}

}  // namespace

void solve_multistart_newton(SolveRun& run) {
  const ContactProblem& p = run.problem();
  const SolverOptions& options = run.options();
  const Parameters& parameters = run.parameters();
  const int starts = parameters.integer("starts"), steps = parameters.integer("steps_each");
  run.judge_every_iteration();
  const ContactScaling scaling = equilibrated_scaling(p, run.delassus().diagonal());
  const double largest = p.u_free.cwiseProduct(scaling.velocity).cwiseAbs().maxCoeff();
  StatusNewton newton(p, scaling, largest > 0 ? largest : 1);
  ContactErrorEvaluator evaluate(p);
  const double free_energy = evaluate(Vector::Zero(p.num_rows())).energy;
  PortableRandom random(static_cast<std::uint64_t>(parameters.integer("seed")));
  const Vector s0 = run.start();
  run.end_setup();

  // One or two more steps bring an answer to rounding, which large friction may need. An impulse
  // that meets the tolerance in double precision may miss it in extended precision
  // (solvers/proved_claim.h).
  const auto polish = [&](Vector& y, double error) {
    for (int k = 0; k < kPolish && error <= options.tol; ++k) {
      Vector next = y;
      newton.update(next, 1, random);
      if (!newton.step(next)) return;
      const double better = evaluate(newton.impulse(next)).guarded();
      if (!(better < error)) return;
      y = next;
      error = better;
    }
  };

  int iteration = 0, start = 0, cancellations = 0;
  bool done = run.stop(0, s0);
  const bool warm = s0.squaredNorm() > 0;
  Vector arrived;  // result of the sweeps, which Newton then improves
  const auto begin = [&](int number) -> Vector {
    if (warm && number == 0) return newton.unknowns(s0);
    if (number > (warm ? 1 : 0)) {
      const bool near = number % 2 == 0;
      return redrawn(newton.unknowns(run.best_impulse()), near ? kRedrawn : 1, random, p.dim);
    }
    SolverOptions sweeps = options;
    sweeps.parameters.clear();
    sweeps.on_iteration = nullptr;
    sweeps.max_iterations = std::min(kSweeps, options.max_iterations - iteration);
    sweeps.time_limit = run.remaining_seconds();
    const SolveResult swept = run.nested(require_solver("pgs"), sweeps, run.whole().share());
    iteration += swept.iterations;
    if (is_success(swept.status)) arrived = swept.s;
    if (iteration >= options.max_iterations) done = run.stop(iteration, swept.s, kNaN, true);
    return newton.unknowns(swept.s);
  };
  for (; start < starts && !done; ++start) {
    Vector y = begin(start);
    int fewest = std::numeric_limits<int>::max(), since = 0;
    for (int k = 0; k < steps && since < kPatience && !done; ++k) {
      const int contradictions = newton.update(y, k < kWholeSteps ? 1 : kShare, random);
      since = contradictions < fewest ? 0 : since + 1;
      fewest = std::min(fewest, contradictions);
      if (!newton.step(y)) break;
      const ContactError error = evaluate(newton.impulse(y));
      if (!(error.energy <= kWild * free_energy)) break;
      polish(y, error.guarded());
      if (cancellations < kCancellations && error.guarded() <= kNearlyThere * options.tol) {
        ++cancellations;
        Vector s = newton.impulse(y);
        cancel_rounding(p, options, evaluate, s);
        if (run.meets(s)) {
          done = run.stop(++iteration, s, kNaN, true);
          break;
        }
      }
      // Another start changes an impulse that one step left unchanged: this is no stall.
      done = run.stop(++iteration, newton.impulse(y), kNaN, true);
    }
    if (!done && arrived.size() != 0) done = run.stop(iteration, arrived, kNaN, true);
    done = done || run.end_if_out_of_time(iteration);
  }
  if (!done) {
    run.end(SolveStatus::kStalled,
            fmt::format("none of {} starts arrived in {} Newton steps, best error {:.2e}", starts,
                        iteration, run.best_error()));
  }
  run.remark(fmt::format("; {} start{}", start, start == 1 ? "" : "s"));
}

}  // namespace bipot
