#include "core/problem_files/problem_form.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/linear/dense_factor.h"
#include "core/linear/sparse_factor.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

template <class Sparse>
void drop_zeros(Sparse& matrix) {
  matrix.prune([](Eigen::Index, Eigen::Index, double value) { return value != 0; });
  matrix.makeCompressed();
}

void require_size(const char* field, Eigen::Index got, Eigen::Index want) {
  if (got == want) return;
  throw std::invalid_argument(fmt::format("{} is {}, expected {}", field, got, want));
}

/// validate() checks the dimension of problems with rolling friction.
void require_dim(int dim, const Vector& mu_r) {
  if (dim == 2 || dim == 3 || mu_r.size() > 0) return;
  throw std::invalid_argument(fmt::format(
      "contact dimension {} is neither 2 nor 3 (formats of other codes hold no rolling friction)",
      dim));
}

ContactProblem checked(ContactProblem problem) {
  if (std::string defect = validate(problem); !defect.empty()) {
    throw std::invalid_argument(defect);
  }
  return problem;
}

}  // namespace

ContactProblem from_local_form(int dim, const SparseRows& W, Vector q, Vector mu, Vector mu_r,
                               Vector mu_spin) {
  require_dim(dim, mu_r);
  const Eigen::Index rows = dim * mu.size();
  require_size("number of rows of W", W.rows(), rows);
  require_size("number of columns of W", W.cols(), rows);
  require_size("size of q", q.size(), rows);
  ContactProblem p{.dim = dim,
                   .W = W,
                   .u_free = std::move(q),
                   .mu = std::move(mu),
                   .mu_r = std::move(mu_r),
                   .mu_spin = std::move(mu_spin)};
  drop_zeros(p.W);
  return checked(std::move(p));
}

ContactProblem from_local_form(int dim, const SparseRows& W, const Vector& q, Vector mu,
                               const SparseRows& V, const SparseMatrix& R, const Vector& s) {
  using Eigen::MatrixXd;
  constexpr std::size_t kMostRows = 5000;
  constexpr double kDependent = 1e-8, kContradicts = 1e-6;
  const Eigen::Index rows = s.size();
  require_size("number of rows of V", V.rows(), W.rows());
  require_size("number of columns of V", V.cols(), rows);
  require_size("number of rows of R", R.rows(), rows);
  require_size("number of columns of R", R.cols(), rows);
  require_size("size of q", q.size(), W.rows());
  if (to_size(rows) > kMostRows) {
    throw std::invalid_argument(
        fmt::format("{} equality rows; at most {} can be eliminated", rows, kMostRows));
  }
  Vector scale(rows);  // to a unit diagonal of R
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double diagonal = R.coeff(k, k);
    if (!(diagonal > 0) || !std::isfinite(diagonal)) {
      throw std::invalid_argument(fmt::format("R({0}, {0}) = {1} is not positive", k, diagonal));
    }
    scale[k] = 1 / std::sqrt(diagonal);
  }
  std::vector<int> touched;  // rows of contacts
  for (int i = 0; i < V.rows(); ++i) {
    if (SparseRows::InnerIterator(V, i)) touched.push_back(i);
  }
  if (touched.size() > kMostRows) {
    throw std::invalid_argument(
        fmt::format("equality rows touch {} rows of contacts; at most {} are possible",
                    touched.size(), kMostRows));
  }
  // The right-hand sides Vᵀ of these, and s.
  MatrixXd sides(rows, static_cast<Eigen::Index>(touched.size()) + 1);
  for (std::size_t k = 0; k < touched.size(); ++k) {
    sides.col(static_cast<Eigen::Index>(k)) = Vector(V.row(touched[k]).transpose());
  }
  sides.rightCols(1) = s;
  sides = scale.asDiagonal() * sides;
  const MatrixXd unit = scale.asDiagonal() * MatrixXd(R) * scale.asDiagonal();
  if (!unit.allFinite() || !sides.allFinite()) {
    throw std::invalid_argument("V, R or s has an entry that is not finite");
  }
  const MatrixXd solved = least_norm_columns(unit, sides, kDependent);
  const MatrixXd miss = unit * solved - sides;
  Eigen::Index row = 0, column = 0;
  if (miss.cwiseAbs().maxCoeff(&row, &column) > kContradicts * sides.cwiseAbs().maxCoeff()) {
    throw std::invalid_argument(
        fmt::format("equality row {} of V, R and s contradicts other rows", row));
  }
  const MatrixXd change = sides.transpose() * solved;  // the last column: of q
  const Eigen::Index count = change.rows() - 1;
  Triplets entries;
  Vector q_left = q;
  for (Eigen::Index k = 0; k < count; ++k) {
    q_left[touched[to_size(k)]] -= change(k, count);
    for (Eigen::Index l = 0; l < count; ++l) {
      const double value = 0.5 * (change(k, l) + change(l, k));
      if (value != 0) entries.emplace_back(touched[to_size(k)], touched[to_size(l)], -value);
    }
  }
  const SparseRows correction = from_triplets<SparseRows>(W.rows(), W.cols(), entries);
  return from_local_form(dim, SparseRows(W + correction), std::move(q_left), std::move(mu));
}

Vector velocity_of(const SparseMatrix& M, const Vector& f) {
  if (is_diagonal(M)) return f.cwiseQuotient(M.diagonal());
  SparseCholesky factor;
  if (!factor.factor(M)) throw std::invalid_argument("M is not positive definite");
  return factor.solve(f);
}

ContactProblem from_global_form(int dim, const SparseMatrix& M, const SparseMatrix& H,
                                const Vector& f, const Vector& w, Vector mu, Vector mu_r,
                                Vector mu_spin) {
  require_dim(dim, mu_r);
  require_size("number of columns of M", M.cols(), M.rows());
  require_size("number of rows of H", H.rows(), M.rows());
  require_size("number of columns of H", H.cols(), dim * mu.size());
  require_size("size of f", f.size(), M.rows());
  require_size("size of w", w.size(), H.cols());
  ContactProblem p{.dim = dim,
                   .A = M,
                   .H = H,
                   .mu = std::move(mu),
                   .mu_r = std::move(mu_r),
                   .mu_spin = std::move(mu_spin)};
  drop_zeros(p.A);
  drop_zeros(p.H);
  // Validates the matrices first: a factorisation would hide their errors.
  p.v_free = Vector::Zero(p.A.rows());
  p.u_free = w;
  p = checked(std::move(p));
  p.v_free = velocity_of(p.A, f);
  if (!is_diagonal(p.A) && p.num_rows() > 0) p.W = assemble_delassus(p.A, p.H, p.dim);
  p.u_free = p.H.transpose() * p.v_free + w;
  return checked(std::move(p));
}

}  // namespace bipot
