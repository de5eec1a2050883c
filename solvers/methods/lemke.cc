#include "solvers/methods/lemke.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/portable_random.h"
#include "core/linear/dense_factor.h"
#include "core/problem/delassus.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

using Dense = Eigen::MatrixXd;

// Entries of an entering column below this, relative to its largest, count as zero.
constexpr double kZero = 1e-10;
// Ratios a / b that differ by less are ties: kTie relative, and kNoise / b for the rounding of a
// (all data are of size one).
constexpr double kTie = 1e-11, kNoise = 1e-13;
// Longest path of one covering vector, for each row of the complementarity problem; a cycle through
// rounding has no end.
constexpr int kLongestPath = 40;
// Pivots between two inversions of the basis.
constexpr int kRefresh = 64;
// Number of covering vectors tried.
constexpr int kDraws = 5;
// Guarded error of a basis that only rounding keeps from the tolerance.
constexpr double kNearlyExact = 1e-6;

/// w = M z + q, 0 <= w ⟂ z >= 0.
struct Complementarity {
  Dense M;
  Vector q;
  Vector normal;  ///< c, x_n = normal ∘ z_n
};

/// The law in equilibrated impulses x = impulse ∘ s, over the largest free velocity. Blocks of z:
/// normal, then b+, b-, l of the tangents, and the same of rolling, each with one entry for each
/// contact. With large friction, normal impulses are small beside the tangential ones: z_n is
/// max(1, mu) x_n.
Complementarity stewart_trinkle(const ContactProblem& p, const ContactScaling& scaling,
                                double unit) {
  const int c = p.num_contacts(), d = p.dim;
  const int blocks = 1 + 3 * (d - 1);
  // Block b+ of the rows k of the contacts, k > 0; b- is the next one, l the one after.
  const auto plus = [&](int k) { return (3 * k - 2) * c; };
  Complementarity out{Dense::Zero(blocks * c, blocks * c), Vector::Zero(blocks * c),
                      Vector::Ones(c)};
  for (int i = 0; i < p.num_rows(); ++i) {
    const int contact = i / d;
    const int k = i % d;
    const bool tangential = k > 0;
    const double b = p.u_free[i] * scaling.velocity[i] / unit;
    if (tangential) {
      out.q[plus(k) + contact] = b;
      out.q[plus(k) + c + contact] = -b;
    } else {
      out.q[contact] = b;
    }
    for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
      const int j = static_cast<int>(it.col());
      const int other = j / d;
      const int l = j % d;
      const double w = it.value() * scaling.velocity[i] * scaling.velocity[j];
      for (int row_sign = tangential ? -1 : 1; row_sign <= 1; row_sign += 2) {
        const int row = tangential ? plus(k) + (row_sign > 0 ? 0 : c) + contact : contact;
        if (l > 0) {
          out.M(row, plus(l) + other) += row_sign * w;
          out.M(row, plus(l) + c + other) -= row_sign * w;
        } else {
          out.M(row, other) += row_sign * w;
        }
      }
    }
  }
  for (int k = 1; k < d; ++k) {
    const Vector& bounds = k == 1 ? scaling.mu : scaling.mu_r;
    for (int contact = 0; contact < c; ++contact) {
      const int positive = plus(k) + contact, negative = positive + c, speed = negative + c;
      out.M(positive, speed) = 1;
      out.M(negative, speed) = 1;
      out.M(speed, contact) = bounds[contact];
      out.M(speed, positive) = -1;
      out.M(speed, negative) = -1;
      out.normal[contact] = std::min(out.normal[contact], 1 / std::max(1.0, bounds[contact]));
    }
  }
  for (int contact = 0; contact < c; ++contact) out.M.col(contact) *= out.normal[contact];
  return out;
}

enum class Ending { kSolved, kRay, kSingular, kLongPath, kIterationLimit, kOutOfTime };

/// Lemke's algorithm on I w - M z - cover z0 = q. Variables: w_i is i, z_i is n + i, z0 is 2n.
class Pivoting {
 public:
  Pivoting(const Complementarity& lcp, Vector cover)
      : lcp_(lcp),
        cover_(std::move(cover)),
        n_(static_cast<int>(lcp.q.size())),
        basis_(Eigen::VectorXi::LinSpaced(n_, 0, n_ - 1)),
        inverse_(Dense::Identity(n_, n_)),
        values_(lcp.q) {}

  Ending run(int max_pivots, SolveRun& solve) {
    if (values_.minCoeff() >= 0) return Ending::kSolved;
    Vector column = inverse_ * this->column(2 * n_);
    int row = first_row();
    int entering = 2 * n_;
    for (;;) {
      if (pivots_ >= max_pivots) return Ending::kIterationLimit;
      if (solve.out_of_time()) return Ending::kOutOfTime;
      if (pivots_ >= kLongestPath * n_) return Ending::kLongPath;
      const int leaving = basis_[row];
      pivot(row, entering, column);
      ++pivots_;
      if (leaving == 2 * n_) return Ending::kSolved;
      if (pivots_ % kRefresh == 0 && !refresh(solve)) return Ending::kSingular;
      entering = leaving < n_ ? leaving + n_ : leaving - n_;
      column = inverse_ * this->column(entering);
      row = blocking_row(column);
      if (row < 0) return Ending::kRay;
    }
  }

  /// z of the final basis, solved from the data with refinement.
  Vector solution() const {
    const Dense basis = this->basis();
    const DenseLu lu(basis);
    if (!lu.ok()) return Vector::Constant(n_, kNaN);
    Vector x = lu.solve(lcp_.q);
    for (int step = 0; step < 3; ++step) x += lu.solve(lcp_.q - basis * x);
    Vector z = Vector::Zero(n_);
    for (int i = 0; i < n_; ++i) {
      if (basis_[i] >= n_ && basis_[i] < 2 * n_) z[basis_[i] - n_] = std::max(x[i], 0.0);
    }
    return z;
  }
  int pivots() const { return pivots_; }

 private:
  Vector column(int variable) const {
    if (variable < n_) return Vector::Unit(n_, variable);
    if (variable < 2 * n_) return -lcp_.M.col(variable - n_);
    return -cover_;
  }

  Dense basis() const {
    Dense columns(n_, n_);
    for (int i = 0; i < n_; ++i) columns.col(i) = column(basis_[i]);
    return columns;
  }

  /// Row i before row j in the order of (values, inverse rows) over the divisors.
  bool lexicographically_less(int i, double by_i, int j, double by_j) const {
    const double noise = kNoise * (1 / by_i + 1 / by_j);
    const auto compare = [&](double a, double b) {
      if (std::abs(a - b) <= kTie * std::max(std::abs(a), std::abs(b)) + noise) return 0;
      return a < b ? -1 : 1;
    };
    if (const int order = compare(values_[i] / by_i, values_[j] / by_j); order != 0) {
      return order < 0;
    }
    for (int k = 0; k < n_; ++k) {
      if (const int order = compare(inverse_(i, k) / by_i, inverse_(j, k) / by_j); order != 0) {
        return order < 0;
      }
    }
    return false;
  }

  /// z0 enters at the value that makes the most negative row, over its cover, zero.
  int first_row() const {
    int best = 0;
    for (int i = 1; i < n_; ++i) {
      if (lexicographically_less(i, cover_[i], best, cover_[best])) best = i;
    }
    return best;
  }

  /// Row that reaches zero first, -1 for a ray. z0 wins every tie: it ends the run.
  int blocking_row(const Vector& column) const {
    const double zero = kZero * std::max(column.cwiseAbs().maxCoeff(), 1e-300);
    int best = -1;
    for (int i = 0; i < n_; ++i) {
      if (column[i] <= zero) continue;
      if (best < 0 || lexicographically_less(i, column[i], best, column[best])) best = i;
    }
    if (best < 0) return best;
    for (int i = 0; i < n_; ++i) {
      if (basis_[i] == 2 * n_ && column[i] > zero &&
          values_[i] / column[i] <=
              values_[best] / column[best] + kNoise * (1 / column[i] + 1 / column[best])) {
        return i;
      }
    }
    return best;
  }

  void pivot(int row, int entering, const Vector& column) {
    const double by = column[row];
    inverse_.row(row) /= by;
    values_[row] /= by;
    const Eigen::RowVectorXd pivot_row = inverse_.row(row);
    const double pivot_value = values_[row];
    Vector others = column;
    others[row] = 0;
    values_ -= others * pivot_value;
    inverse_.noalias() -= others * pivot_row;
    basis_[row] = entering;
  }

  /// Inverts the basis again. False if it is singular.
  bool refresh(SolveRun& solve) {
    const DenseLu lu(basis());
    if (!lu.ok() || !(lu.reciprocal_condition() > 1e-15)) return false;
    // The longest operation; without it the inverse at hand serves the last pivot.
    if (solve.out_of_time()) return true;
    inverse_ = lu.inverse();
    values_ = inverse_ * lcp_.q;
    return true;
  }

  const Complementarity& lcp_;
  Vector cover_;
  int n_;
  Eigen::VectorXi basis_;
  Dense inverse_;  // of the basis
  Vector values_;  // of the basic variables
  int pivots_ = 0;
};

}  // namespace

void solve_lemke(SolveRun& run) {
  const ContactProblem& p = run.problem();
  const SolverOptions& options = run.options();
  const ContactScaling scaling = equilibrated_scaling(p, run.delassus().diagonal());
  const double unit = p.u_free.cwiseProduct(scaling.velocity).cwiseAbs().maxCoeff();
  const Complementarity lcp = stewart_trinkle(p, scaling, unit);
  run.end_setup();

  int pivots = 0;
  if (!run.stop(0, run.start())) {
    PortableRandom random(1996);
    std::string failures;
    double closest = kInfinity;
    for (int attempt = 0; attempt < kDraws; ++attempt) {
      Vector cover(lcp.q.size());
      for (double& x : cover) x = 0.5 + random.uniform();
      Pivoting lemke(lcp, std::move(cover));
      const Ending ending = lemke.run(options.max_iterations - pivots, run);
      pivots += lemke.pivots();
      if (ending == Ending::kIterationLimit) {
        run.end(SolveStatus::kIterationLimit,
                fmt::format("iteration limit {} reached", options.max_iterations));
        break;
      }
      if (run.end_if_out_of_time(pivots)) break;
      std::string what = ending == Ending::kRay        ? "a ray"
                         : ending == Ending::kLongPath ? "no end within the longest path"
                                                       : "a singular basis";
      if (ending == Ending::kSolved) {
        const Vector z = lemke.solution();
        const int c = p.num_contacts(), d = p.dim;
        Vector s(p.num_rows());
        for (int i = 0; i < c; ++i) {
          s[i * d] = lcp.normal[i] * z[i];
          for (int k = 1; k < d; ++k) {
            const int positive = (3 * k - 2) * c + i;
            s[i * d + k] = z[positive] - z[positive + c];
          }
        }
        s = unit * s.cwiseQuotient(scaling.impulse);
        if (s.allFinite() && run.meets(s)) {
          run.end(SolveStatus::kConverged,
                  fmt::format("complementary basis after {} pivots{}", pivots,
                              attempt > 0 ? fmt::format(", covering vector {} (before: {})",
                                                        attempt + 1, failures)
                                          : ""));
          break;
        }
        // Not accurate enough: another covering vector may lead to a basis with less rounding.
        if (s.allFinite()) closest = std::min(closest, run.last_error());
        what = fmt::format("a basis of error {:.1e}", run.last_error());
      }
      failures += (failures.empty() ? "" : "; ") + what;
      if (attempt == kDraws - 1) {
        if (closest <= kNearlyExact) {
          run.end(SolveStatus::kStalled,
                  fmt::format("stalled: {} covering vectors, the closest basis of error {:.1e}, "
                              "above the tolerance or not to be judged by the stop test",
                              kDraws, closest));
        } else {
          run.end(SolveStatus::kNumericalFailure,
                  fmt::format(
                      "pivoting from {} covering vectors ended on {} after {} pivots: "
                      "no solution exists, or friction or rounding is too large for this method",
                      kDraws, failures, pivots));
        }
      }
    }
  }
  run.set_iterations(pivots);
}

}  // namespace bipot
