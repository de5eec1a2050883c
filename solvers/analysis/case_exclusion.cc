#include "solvers/analysis/case_exclusion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/triplets.h"
#include "core/problem/delassus.h"
#include "solvers/analysis/linear_programme.h"

namespace bipot {
namespace {

constexpr int kMostCases = 20000;
// Tolerance for an optimum that should be 0: the resolution of the pivoting.
constexpr double kSolvable = 1e-9;
constexpr double kLeastMultiplier = 1e-12;  // of the largest: pivoting's rounding
constexpr double kLeastReach = 1e6;         // of one case; below it the case is split further

/// Allowed values of a case for u_n, u_t (its sign; 0: unknown, so no multiplier) and s.
struct Allowed {
  bool free_normal = false;           // u_n = 0: the multiplier may have either sign
  bool above = false, below = false;  // u_t >= 0, u_t <= 0; both: u_t = 0
  double edges[2] = {};               // tangential parts of the edges
  int edge_count = 0;
};

Allowed allowed(CaseExclusion::Status status, double mu) {
  Allowed a;
  const auto edge = [&](double tangent) { a.edges[a.edge_count++] = tangent; };
  switch (status) {
    case CaseExclusion::kOpen:
      break;
    case CaseExclusion::kAny:
    case CaseExclusion::kStick:
      edge(mu);
      if (mu > 0) edge(-mu);
      if (status == CaseExclusion::kAny) break;
      a.free_normal = a.above = a.below = true;
      break;
    case CaseExclusion::kLeft:
      a.free_normal = a.below = true;
      edge(mu);
      break;
    case CaseExclusion::kRight:
      a.free_normal = true;
      a.above = mu > 0;
      edge(-mu);
      break;
  }
  return a;
}

double friction_of(const ContactProblem& p, int contact) { return p.dim == 1 ? 0 : p.mu[contact]; }

/// The linear programmes, with rows and columns of W scaled to a unit diagonal.
class CaseSearch {
 public:
  CaseSearch(const ContactProblem& p, const std::function<bool()>& stopped)
      : p_(p), stopped_(stopped) {
    W_ = p.has_delassus() ? Eigen::MatrixXd(p.W)
                          : Eigen::MatrixXd(assemble_delassus(p.A, p.H, p.dim));
    scale_ = Vector::Ones(W_.rows());
    for (Eigen::Index i = 0; i < W_.rows(); ++i) {
      if (W_(i, i) > 0) scale_[i] = 1 / std::sqrt(W_(i, i));
    }
    const double most = p.u_free.cwiseProduct(scale_).cwiseAbs().maxCoeff();
    b_ = p.u_free.cwiseProduct(scale_) / (most > 0 ? most : 1);
  }

  CaseExclusion run() {
    statuses_.assign(to_size(p_.num_contacts()), CaseExclusion::kAny);
    out_.reach = kInfinity;
    out_.complete = exclude(0);
    if (!out_.complete) out_.cases.clear();
    return std::move(out_);
  }

 private:
  /// Excludes the case of statuses_, in which contacts from `contact` on are not distinguished.
  bool exclude(int contact) {
    if (stopped_() || static_cast<int>(out_.cases.size()) >= kMostCases) {
      out_.message = fmt::format("{} cases were excluded before the limit", out_.cases.size());
      return false;
    }
    CaseExclusion::Case found{statuses_, Vector()};
    if (const double reach = try_to_exclude(found); reach > kLeastReach) {
      out_.reach = std::min(out_.reach, reach);
      out_.cases.push_back(std::move(found));
      return true;
    }
    if (contact == p_.num_contacts()) {
      out_.message = "a case of its contacts cannot be excluded";
      return false;
    }
    const bool slides = friction_of(p_, contact) > 0;
    for (const CaseExclusion::Status status : {CaseExclusion::kOpen, CaseExclusion::kStick,
                                               CaseExclusion::kLeft, CaseExclusion::kRight}) {
      if (!slides && (status == CaseExclusion::kStick || status == CaseExclusion::kLeft)) continue;
      statuses_[to_size(contact)] = status;
      if (!exclude(contact + 1)) return false;
    }
    statuses_[to_size(contact)] = CaseExclusion::kAny;
    return true;
  }

  /// Farkas' multipliers: minimises y·b over y with y·W e <= 0 for all edges, |y| <= 1, and its
  /// signs. Returns their reach, or 0.
  double try_to_exclude(CaseExclusion::Case& found) const {
    const int d = p_.dim;
    std::vector<std::pair<int, double>> unknowns;  // row and sign of each part of y
    std::vector<Vector> edges;
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const double mu = friction_of(p_, c);
      const Allowed a = allowed(statuses_[to_size(c)], mu);
      unknowns.emplace_back(c * d, 1.0);
      if (a.free_normal) unknowns.emplace_back(c * d, -1.0);
      if (a.above) unknowns.emplace_back(c * d + 1, 1.0);
      if (a.below) unknowns.emplace_back(c * d + 1, -1.0);
      for (int k = 0; k < a.edge_count; ++k) {
        // W e in the scaled rows, of unit length.
        Vector column = W_.col(c * d);
        if (d == 2) column += a.edges[k] * W_.col(c * d + 1);
        column = column.cwiseProduct(scale_);
        const double norm = column.norm();
        if (norm > 0) edges.push_back(column / norm);
      }
    }
    const int n = static_cast<int>(unknowns.size()), k = static_cast<int>(edges.size());
    LinearProgramme lp;
    Triplets entries;
    lp.cost = Vector::Zero(n + k);
    lp.upper = Vector::Ones(n + k);
    for (int j = 0; j < n; ++j) {
      const auto [row, sign] = unknowns[to_size(j)];
      lp.cost[j] = sign * b_[row];
      for (int e = 0; e < k; ++e) {
        const double rate = sign * edges[to_size(e)][row];
        if (rate != 0) entries.emplace_back(e, j, rate);
      }
    }
    for (int e = 0; e < k; ++e) {
      entries.emplace_back(e, n + e, 1.0);
      lp.upper[n + e] = kInfinity;
    }
    lp.A = from_triplets(k, n + k, entries);
    const LinearProgramme::Optimum best = bipot::solve(lp, stopped_);
    if (!best.found || !(best.value < -kSolvable)) return 0;
    found.multipliers = Vector::Zero(W_.rows());
    for (int j = 0; j < n; ++j) {
      const auto [row, sign] = unknowns[to_size(j)];
      if (best.x[j] > kLeastMultiplier) found.multipliers[row] += sign * best.x[j] * scale_[row];
    }
    return reach_of_exclusion(p_, found);
  }

  const ContactProblem& p_;
  const std::function<bool()>& stopped_;
  Eigen::MatrixXd W_;
  Vector scale_, b_;
  std::vector<CaseExclusion::Status> statuses_;
  CaseExclusion out_;
};

using Wide = long double;

/// yᵀ W, the sum of the absolute values of its terms and their number, in extended precision; by
/// bodies if A is diagonal.
struct Rates {
  std::vector<Wide> value, absolute, normal_diagonal;
  Wide terms = 0;
};

Rates rates_of(const ContactProblem& p, const Vector& y) {
  const std::size_t rows = to_size(p.num_rows());
  Rates r{std::vector<Wide>(rows), std::vector<Wide>(rows), std::vector<Wide>(rows), 0};
  const bool bodies = p.has_velocities() && is_diagonal(p.A);
  if (!bodies) {
    for (int i = 0; i < p.num_rows(); ++i) {
      for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
        const Wide term = static_cast<Wide>(it.value()) * static_cast<Wide>(y[i]);
        r.value[to_size(it.col())] += term;
        r.absolute[to_size(it.col())] += std::abs(term);
        if (it.col() == i) r.normal_diagonal[to_size(i)] += static_cast<Wide>(it.value());
      }
    }
    r.terms = p.num_rows();
    return r;
  }
  const std::size_t dofs = to_size(p.num_dofs());
  std::vector<Wide> v(dofs), size(dofs);
  for (int j = 0; j < p.num_rows(); ++j) {
    for (SparseMatrix::InnerIterator it(p.H, j); it; ++it) {
      const Wide term = static_cast<Wide>(it.value()) * static_cast<Wide>(y[j]);
      v[to_size(it.row())] += term;
      size[to_size(it.row())] += std::abs(term);
    }
  }
  for (int j = 0; j < p.num_rows(); ++j) {
    for (SparseMatrix::InnerIterator it(p.H, j); it; ++it) {
      const std::size_t i = to_size(it.row());
      const Wide h = static_cast<Wide>(it.value());
      const Wide over = h / static_cast<Wide>(p.A.coeff(it.row(), it.row()));
      r.value[to_size(j)] += over * v[i];
      r.absolute[to_size(j)] += std::abs(over) * size[i];
      r.normal_diagonal[to_size(j)] += h * over;
    }
  }
  r.terms = p.num_rows() + p.num_dofs();
  return r;
}

}  // namespace

double reach_of_exclusion(const ContactProblem& p, const CaseExclusion::Case& excluded) {
  const Vector& y = excluded.multipliers;
  if (y.size() != p.num_rows() || !y.allFinite()) return 0;
  if (!(p.has_velocities() && is_diagonal(p.A)) && !p.has_delassus()) return 0;
  const Rates rates = rates_of(p, y);
  const Wide unit = std::numeric_limits<Wide>::epsilon() * (rates.terms + 16);
  Wide work = 0, absolute = 0, data2 = 0, resistance = 0;
  for (int i = 0; i < p.num_rows(); ++i) {
    const Wide term = static_cast<Wide>(y[i]) * static_cast<Wide>(p.u_free[i]);
    work -= term;
    absolute += std::abs(term);
  }
  work -= unit * absolute;
  if (!(work > 0)) return 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const std::size_t n = to_size(c * p.dim);
    const double mu = friction_of(p, c);
    const Allowed a = allowed(excluded.statuses[to_size(c)], mu);
    if (!a.free_normal && y[c * p.dim] < 0) return 0;
    if (p.dim == 2) {
      const double y_t = y[c * p.dim + 1];
      if ((y_t > 0 && !a.above) || (y_t < 0 && !a.below)) return 0;
    }
    const Wide w_nn = rates.normal_diagonal[n];
    if (!(w_nn > 0)) return 0;
    for (int k = 0; k < p.dim; ++k) {
      const Wide w = static_cast<Wide>(p.u_free[c * p.dim + k]);
      data2 += w * w / w_nn;
    }
    for (int k = 0; k < a.edge_count; ++k) {
      Wide rate = rates.value[n], size = rates.absolute[n];
      if (p.dim == 2) {
        rate += static_cast<Wide>(a.edges[k]) * rates.value[n + 1];
        size += std::abs(static_cast<Wide>(a.edges[k])) * rates.absolute[n + 1];
      }
      resistance += std::max<Wide>(rate + unit * size, 0) / std::sqrt(w_nn);
    }
  }
  if (resistance == 0) return kInfinity;
  return static_cast<double>(work / (resistance * std::sqrt(data2)));
}

CaseExclusion exclude_cases(const ContactProblem& p, const std::function<bool()>& stopped) {
  if (p.dim > 2 || p.num_contacts() > kMostContactsByCases) {
    return {.message = "too many contacts or dimensions to go through the cases"};
  }
  return CaseSearch(p, stopped).run();
}

}  // namespace bipot
