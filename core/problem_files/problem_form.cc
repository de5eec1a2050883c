#include "core/problem_files/problem_form.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

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

void require_dim(int dim) {
  if (dim == 2 || dim == 3) return;
  throw std::invalid_argument(
      fmt::format("contact dimension {} is neither 2 nor 3 (other contact laws, such as rolling "
                  "friction, are not supported)",
                  dim));
}

ContactProblem checked(ContactProblem problem) {
  if (std::string defect = validate(problem); !defect.empty()) {
    throw std::invalid_argument(defect);
  }
  return problem;
}

}  // namespace

ContactProblem from_local_form(int dim, const SparseRows& W, Vector q, Vector mu) {
  require_dim(dim);
  const Eigen::Index rows = dim * mu.size();
  require_size("number of rows of W", W.rows(), rows);
  require_size("number of columns of W", W.cols(), rows);
  require_size("size of q", q.size(), rows);
  ContactProblem p{.dim = dim, .W = W, .u_free = std::move(q), .mu = std::move(mu)};
  drop_zeros(p.W);
  return checked(std::move(p));
}

ContactProblem from_global_form(int dim, const SparseMatrix& M, const SparseMatrix& H,
                                const Vector& f, const Vector& w, Vector mu) {
  require_dim(dim);
  require_size("number of columns of M", M.cols(), M.rows());
  require_size("number of rows of H", H.rows(), M.rows());
  require_size("number of columns of H", H.cols(), dim * mu.size());
  require_size("size of f", f.size(), M.rows());
  require_size("size of w", w.size(), H.cols());
  ContactProblem p{.dim = dim, .A = M, .H = H, .mu = std::move(mu)};
  drop_zeros(p.A);
  drop_zeros(p.H);
  // Validates the matrices first: a factorisation would hide their errors.
  p.v_free = Vector::Zero(p.A.rows());
  p.u_free = w;
  p = checked(std::move(p));
  if (is_diagonal(p.A)) {
    p.v_free = f.cwiseQuotient(p.A.diagonal());
  } else {
    SparseCholesky factor;
    if (!factor.factor(p.A)) throw std::invalid_argument("M is not positive definite");
    p.v_free = factor.solve(f);
    if (p.num_rows() > 0) p.W = assemble_delassus(p.A, p.H, p.dim);
  }
  p.u_free = p.H.transpose() * p.v_free + w;
  return checked(std::move(p));
}

}  // namespace bipot
