#include "solvers/analysis/existence.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/stopwatch.h"
#include "core/base/triplets.h"
#include "core/linear/sparse_factor.h"
#include "core/problem/coulomb_cone.h"
#include "solvers/analysis/case_exclusion.h"
#include "solvers/analysis/certificate_check.h"
#include "solvers/analysis/linear_programme.h"

namespace bipot {
namespace {

// Tolerance for an optimum that should be 0: the resolution of the pivoting.
constexpr int kEdges = 16;  // of the widened cone in 3D
constexpr double kZero = 1e-9;
constexpr double kRounding = 1e-12;  // relative change of the data that still counts as rounding
constexpr double kLeastSpeed = 1e6;  // of a motion that a self-stress leaves possible

/// The ends of a part of `count` rows that friction bounds by mu (two rows: of a polygon around the
/// circle).
std::vector<std::vector<double>> ends_of(int count, double mu) {
  if (mu == 0) return {std::vector<double>(to_size(count), 0.0)};
  if (count == 1) return {{mu}, {-mu}};
  std::vector<std::vector<double>> ends;
  const double wide = mu / std::cos(std::numbers::pi / kEdges);
  for (int k = 0; k < kEdges; ++k) {
    const double angle = 2 * std::numbers::pi * k / kEdges;
    ends.push_back({wide * std::cos(angle), wide * std::sin(angle)});
  }
  return ends;
}

/// The edges of a contact's cone (in 3D: of one around it), normal part 1: every choice of an end in
/// each part. Without friction if `normals_only`.
std::vector<std::vector<double>> edges_of(const ContactProblem& p, int contact, bool normals_only) {
  std::vector<std::vector<double>> edges{{1}};
  dispatch_rows(p, [&](auto rows) {
    constexpr ContactRows K = rows();
    each_bounded<K>(friction_of<K>(p, contact), [&](auto, auto count, double bound) {
      std::vector<std::vector<double>> more;
      for (const auto& edge : edges) {
        for (const auto& end : ends_of(count(), normals_only ? 0.0 : bound)) {
          more.push_back(edge);
          more.back().insert(more.back().end(), end.begin(), end.end());
        }
      }
      edges = std::move(more);
    });
  });
  return edges;
}

/// The linear programmes of one problem, equilibrated: rows by the square root of the masses (or of
/// the diagonal of W), columns to unit length.
class Search {
 public:
  Search(const ContactProblem& problem, double seconds, const std::function<bool()>& cancelled)
      : p_(problem), seconds_(seconds), cancelled_(cancelled) {
    wrench_ = p_.has_velocities() ? p_.H : SparseMatrix(p_.W);
    const Vector diagonal = p_.has_velocities() ? Vector(p_.A.diagonal()) : Vector(p_.W.diagonal());
    row_scale_ = Vector::Ones(diagonal.size());
    for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
      if (diagonal[i] > 0) row_scale_[i] = 1 / std::sqrt(diagonal[i]);
    }
  }

  ExistenceCertificate run() {
    ExistenceCertificate found;
    const std::string without = defect();
    std::string why = without.empty() ? try_programmes(found) : without;
    if (found.verdict == Existence::kUndecided) try_cases(found);
    if (found.verdict != Existence::kUndecided) return found;
    if (without.empty() && stopped_()) {
      why = fmt::format("{}, {}", cancelled() ? "interrupted" : "out of time", why);
    }
    found.reason = why;
    return found;
  }

 private:
  /// Programmes 1 to 3; returns the reason if nothing was proved.
  std::string try_programmes(ExistenceCertificate& found) const {
    std::string why = try_opening(found);
    if (found.verdict != Existence::kUndecided || stopped_()) return why;
    if (p_.plain_dim() <= 2 && try_undoing(found)) return {};
    if (const std::string more = try_obstruction(found); !more.empty()) why = more;
    if (found.verdict != Existence::kUndecided) return {};
    if (p_.plain_dim() <= 2) {
      if (const std::string more = try_reachable(found); !more.empty()) why = more;
    }
    return why;
  }

  void try_cases(ExistenceCertificate& found) const {
    const CaseExclusion all = exclude_cases(p_, stopped_);
    if (!all.complete) return;
    found.verdict = Existence::kNone;
    found.margin = 1 / all.reach;
    found.cases = static_cast<int>(all.cases.size());
    found.reason = fmt::format(
        "open, sticking or slipping, no case of its {} contacts is possible: {} exclusions",
        p_.num_contacts(), found.cases);
  }

  bool cancelled() const { return cancelled_ && cancelled_(); }

  /// Reason why the theory does not apply to this W.
  std::string defect() const {
    if (p_.has_velocities()) return {};
    const SparseMatrix W(p_.W), skew = W - SparseMatrix(W.transpose());
    const Vector diagonal = W.diagonal();
    for (int k = 0; k < skew.outerSize(); ++k) {
      for (SparseMatrix::InnerIterator it(skew, k); it; ++it) {
        const double scale = std::sqrt(std::abs(diagonal[it.row()] * diagonal[it.col()]));
        if (std::abs(it.value()) > kRounding * scale) {
          return fmt::format("W is not symmetric: W({0}, {1}) - W({1}, {0}) = {2:.3g}", it.row(),
                             it.col(), it.value());
        }
      }
    }
    SparseMatrix shifted = 0.5 * (W + SparseMatrix(W.transpose()));
    const double most = diagonal.maxCoeff();
    for (Eigen::Index i = 0; i < diagonal.size(); ++i) {
      shifted.coeffRef(i, i) += kRounding * (diagonal[i] > 0 ? diagonal[i] : most);
    }
    shifted.makeCompressed();
    SparseCholesky factor;
    return factor.factor(shifted) ? "" : "W is not positive semidefinite";
  }

  /// The columns of wrench_ times the edges of the cones (or times the normals), of unit length.
  struct Stresses {
    SparseMatrix columns;
    Vector work;  // of each column on the data, r·w over work_scale
    double work_scale = 1;
    std::vector<int> contact;   // of each column
    std::vector<double> scale;  // to its unit length
  };
  Stresses stresses(bool normals_only) const {
    Stresses all;
    Triplets entries;
    std::vector<double> works;
    int column = 0;
    Vector sum = Vector::Zero(wrench_.rows());
    for (int c = 0; c < p_.num_contacts(); ++c) {
      for (const auto& edge : edges_of(p_, c, normals_only)) {
        double norm2 = 0, w = 0;
        std::vector<Eigen::Index> touched;
        for (int k = 0; k < p_.dim; ++k) {
          const Eigen::Index row = static_cast<Eigen::Index>(c) * p_.dim + k;
          w += edge[to_size(k)] * p_.u_free[row];
          for (SparseMatrix::InnerIterator it(wrench_, row); it; ++it) {
            if (sum[it.row()] == 0) touched.push_back(it.row());
            sum[it.row()] += edge[to_size(k)] * it.value() * row_scale_[it.row()];
          }
        }
        for (const Eigen::Index i : touched) norm2 += sum[i] * sum[i];
        const double by = norm2 > 0 ? 1 / std::sqrt(norm2) : 1;
        for (const Eigen::Index i : touched) {
          if (sum[i] != 0) entries.emplace_back(static_cast<int>(i), column, by * sum[i]);
          sum[i] = 0;
        }
        works.push_back(by * w);
        all.contact.push_back(c);
        all.scale.push_back(by);
        ++column;
      }
    }
    all.work = Eigen::Map<const Vector>(works.data(), column);
    const double most = all.work.cwiseAbs().maxCoeff();
    if (most > 0) all.work_scale = most;
    all.work /= all.work_scale;
    all.columns = from_triplets(wrench_.rows(), column, entries);
    return all;
  }
  /// The least work of shares of at most 1 that are in balance.
  LinearProgramme::Optimum least_work(const Stresses& all) const {
    return solve({all.columns, all.work, Vector::Ones(all.work.size())}, stopped_);
  }

  /// Programme 1.
  std::string try_opening(ExistenceCertificate& found) const {
    const Stresses all = stresses(false);
    const Eigen::Index n = all.columns.cols(), k = all.columns.rows();
    LinearProgramme lp;
    Triplets entries;
    for (int c = 0; c < n; ++c) {
      for (SparseMatrix::InnerIterator it(all.columns, c); it; ++it) {
        entries.emplace_back(it.row(), it.col(), it.value());
      }
      if (all.work[c] != 0) entries.emplace_back(static_cast<int>(k), c, all.work[c]);
    }
    entries.emplace_back(static_cast<int>(k), static_cast<int>(n), 1.0);  // slack: r·w <= 0
    lp.A = from_triplets(k + 1, n + 1, entries);
    lp.cost = -Vector::Ones(n + 1);
    lp.cost[n] = 0;
    lp.upper = Vector::Ones(n + 1);
    lp.upper[n] = kInfinity;
    const LinearProgramme::Optimum best = solve(lp, stopped_);
    if (!best.found) return best.message;
    if (best.value < -0.5) {  // 0, or at least 1: a self-stress can grow until one share is 1
      return "there is a self-stress in the friction cones: contacts can be jammed";
    }
    Vector y = -best.y.head(k).cwiseProduct(row_scale_);
    double weight = std::max(0.0, -best.y[k]) / all.work_scale;
    // Powers of two, hence without rounding: values near 1 avoid the ends of the range.
    const double most = std::max(y.cwiseAbs().maxCoeff(), weight);
    const double unit = most > 0 && std::isfinite(most) ? std::exp2(-std::ilogb(most)) : 1;
    y *= unit;
    weight *= unit;
    const double margin = opening_margin(p_, y, weight);
    if (!(margin > 0)) {
      return fmt::format(
          "no self-stress was found, but the motion that should open every contact does not "
          "survive the check in extended precision (margin {:.1e})",
          margin);
    }
    found.verdict = Existence::kExists;
    found.margin = margin;
    found.motion = y;
    found.weight = weight;
    found.reason = "there is no self-stress in the friction cones: a motion opens every contact";
    return {};
  }

  /// Programme 2.
  std::string try_obstruction(ExistenceCertificate& found) const {
    const Stresses all = stresses(true);
    const LinearProgramme::Optimum best = least_work(all);
    if (!best.found) return best.message;
    if (!(best.value < -kZero)) return {};
    Vector stress = Vector::Zero(p_.num_contacts());
    for (std::size_t k = 0; k < all.contact.size(); ++k) {
      const double x = best.x[static_cast<Eigen::Index>(k)];
      if (x > 1e-12) stress[all.contact[k]] = x * all.scale[k];
    }
    stress /= std::exp2(std::ilogb(stress.maxCoeff()));
    const Obstruction proof = obstruction(p_, stress);
    if (!(proof.strength > kRounding) || !(proof.speed > kLeastSpeed)) {
      return fmt::format(
          "a normal self-stress works against the data, but by rounding only (share {:.1e}, "
          "speed {:.1e})",
          proof.strength, proof.speed);
    }
    found.verdict = Existence::kNone;
    found.margin = 1 / proof.speed;
    found.stress = stress;
    found.reason = fmt::format(
        "{} contacts are driven together: a normal self-stress does the work {:.2g} of its size on "
        "the data",
        (stress.array() > 0).count(), -proof.strength);
    return {};
  }

  /// The motion that inverts a motion from which the data came: Hᵀ v = -w.
  bool try_undoing(ExistenceCertificate& found) const {
    if (!p_.has_velocities() || p_.v_free.size() != p_.H.rows()) return false;
    return accept_reachable(-p_.v_free, "the data are those of a motion, which can be undone",
                            found);
  }

  bool accept_reachable(const Vector& y, const char* reason, ExistenceCertificate& found) const {
    const double margin = opening_margin(p_, y, 1);
    if (!(margin > -kRounding)) return false;
    found.verdict = Existence::kExistsNearby;
    found.margin = std::max(-margin, 0.0);
    found.motion = y;
    found.weight = 1;
    found.reason = reason;
    return true;
  }

  /// Programme 3.
  std::string try_reachable(ExistenceCertificate& found) const {
    const Stresses all = stresses(false);
    const LinearProgramme::Optimum best = least_work(all);
    if (!best.found) return best.message;
    if (best.value < -kZero) return "a self-stress in the friction cones works against the data";
    const Vector y = -all.work_scale * best.y.cwiseProduct(row_scale_);
    accept_reachable(y,
                     "no self-stress in the friction cones works against the data: a motion leaves "
                     "every contact",
                     found);
    return {};
  }

  const ContactProblem& p_;
  double seconds_;
  const std::function<bool()>& cancelled_;
  Stopwatch watch_;
  const std::function<bool()> stopped_ = [this] {
    return cancelled() || watch_.seconds() >= seconds_;
  };
  SparseMatrix wrench_;
  Vector row_scale_;
};

}  // namespace

std::string_view to_string(Existence verdict) {
  static constexpr std::string_view kNames[] = {"undecided", "exists", "exists within rounding",
                                                "none"};
  return kNames[static_cast<int>(verdict)];
}

ExistenceCertificate certify_existence(const ContactProblem& problem, double seconds,
                                       const std::function<bool()>& cancelled) {
  const Stopwatch watch;
  ExistenceCertificate found;
  if (problem.num_contacts() == 0) {
    found.verdict = Existence::kExists;
    found.margin = 1;
    found.reason = "there are no contacts";
  } else {
    found = Search(problem, seconds, cancelled).run();
  }
  found.seconds = watch.seconds();
  return found;
}

std::string to_text(const ExistenceCertificate& c) {
  switch (c.verdict) {
    case Existence::kExists:
      return fmt::format("a solution exists (proved, margin {:.1e}: {})", c.margin, c.reason);
    case Existence::kExistsNearby:
      return fmt::format(
          "a solution exists for data within {:.1e} of these (proved up to rounding: {})", c.margin,
          c.reason);
    case Existence::kNone:
      return fmt::format(
          "no solution exists (proved, {}: {})",
          c.margin > 0
              ? fmt::format("none {} {:.1e} times the data",
                            c.cases > 0 ? "with impulses below" : "slower than", 1 / c.margin)
              : "exactly",
          c.reason);
    default:
      return "whether a solution exists is undecided: " + c.reason;
  }
}

}  // namespace bipot
