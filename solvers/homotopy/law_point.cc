#include "solvers/homotopy/law_point.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/problem/delassus.h"

namespace bipot {
namespace {

// A smaller friction coefficient has no effect in double precision.
constexpr double kNoFriction = 1e-14;

// Largest difference by rounding of two equal entries of a W with unit diagonal.
constexpr double kSymmetric = 1e-15;

/// Makes entries (i, j) and (j, i) equal if they differ by rounding alone. W is then symmetric to
/// the last bit, and its columns are its rows.
void make_symmetric(SparseMatrix& W) {
  const int* const start = W.outerIndexPtr();
  const int* const row = W.innerIndexPtr();
  double* const value = W.valuePtr();
  // Of each column the first entry below the diagonal that its row has not reached.
  std::vector<int> next(to_size(W.cols()));
  for (int j = 0; j < W.cols(); ++j) {
    const int* const begin = row + start[j];
    next[to_size(j)] = static_cast<int>(std::upper_bound(begin, row + start[j + 1], j) - row);
  }
  for (int j = 0; j < W.cols(); ++j) {
    for (int k = start[j]; k < start[j + 1] && row[k] < j; ++k) {
      const int i = row[k];
      int& other = next[to_size(i)];
      while (other < start[i + 1] && row[other] < j) ++other;
      if (other == start[i + 1] || row[other] != j) continue;
      if (std::abs(value[k] - value[other]) <= kSymmetric) value[other] = value[k];
    }
  }
}

}  // namespace

LawProblem::LawProblem(const ContactProblem& p, const Vector& delassus_diagonal)
    : dim(p.dim), W(p.has_delassus() ? p.W : assemble_delassus(p.A, p.H, p.dim)) {
  const ContactScaling scaling = equilibrated_scaling(p, delassus_diagonal);
  for (int j = 0; j < W.outerSize(); ++j) {
    for (SparseMatrix::InnerIterator it(W, j); it; ++it) {
      it.valueRef() *= scaling.velocity[it.row()] * scaling.velocity[j];
    }
  }
  make_symmetric(W);
  b = p.u_free.cwiseProduct(scaling.velocity);
  const double largest = b.cwiseAbs().maxCoeff();
  const double unit = largest > 0 ? largest : 1;
  b /= unit;
  impulse_unit = unit * scaling.velocity;
  mu = dim > 1 ? scaling.mu : Vector(Vector::Zero(p.num_contacts()));
  for (double& x : mu) {
    if (x < kNoFriction) x = 0;
  }
}

void LawPoint::set(const LawProblem& problem, int contact, Cell to) {
  cell[static_cast<std::size_t>(contact)] = to;
  const auto first = static_cast<std::size_t>(contact) * static_cast<std::size_t>(problem.dim);
  column[first] = to == Cell::kTakeOff     ? Column::kOpening
                  : to == Cell::kSlipMinus ? Column::kMinus
                                           : Column::kPlus;
  if (problem.dim > 1) column[first + 1] = to == Cell::kStick ? Column::kMinus : Column::kSliding;
  for (int k = 0; k < problem.dim; ++k) {
    const auto slot = first + static_cast<std::size_t>(k);
    bound[static_cast<Eigen::Index>(slot)] = bound_of(to, column[slot]);
  }
}

void LawPoint::find_bounds() {
  const std::size_t dim = cell.empty() ? 1 : column.size() / cell.size();
  bound.resize(static_cast<Eigen::Index>(column.size()));
  for (std::size_t slot = 0; slot < column.size(); ++slot) {
    bound[static_cast<Eigen::Index>(slot)] = bound_of(cell[slot / dim], column[slot]);
  }
}

void LawPoint::sort_columns(int dim) {
  if (dim == 1) return;
  for (std::size_t i = 0; i < cell.size(); ++i) {
    const std::size_t first = 2 * i;
    const bool sorted = cell[i] == Cell::kStick ? column[first] == Column::kPlus
                                                : column[first] != Column::kSliding;
    if (sorted) continue;
    const auto at = static_cast<Eigen::Index>(first);
    std::swap(column[first], column[first + 1]);
    std::swap(bound[at], bound[at + 1]);
    std::swap(value[at], value[at + 1]);
  }
}

void LawPoint::impulse(const LawProblem& problem, Vector& s) const {
  s.setZero(problem.num_rows());
  for (Eigen::Index slot = 0; slot < value.size(); ++slot) {
    const Column kind = column[static_cast<std::size_t>(slot)];
    if (!is_impulse(kind)) continue;
    const int contact = static_cast<int>(slot) / problem.dim;
    const Eigen::Index row = contact * problem.dim;
    s[row] += value[slot];
    if (problem.dim > 1) s[row + 1] += problem.tangent(contact, kind) * value[slot];
  }
}

void LawPoint::velocity(const LawProblem& problem, Vector& u) const {
  u.setZero(problem.num_rows());
  for (Eigen::Index slot = 0; slot < value.size(); ++slot) {
    const Column kind = column[static_cast<std::size_t>(slot)];
    const Eigen::Index row = slot / problem.dim * problem.dim;
    if (kind == Column::kOpening) u[row] = value[slot];
    if (kind == Column::kSliding) u[row + 1] = value[slot];
  }
}

LawPoint nearest_point(const LawProblem& problem, const Vector& s, const Vector& u) {
  const int d = problem.dim;
  LawPoint point;
  point.cell.resize(static_cast<std::size_t>(problem.num_contacts()));
  point.column.resize(static_cast<std::size_t>(problem.num_rows()));
  point.bound.resize(problem.num_rows());
  point.value.resize(problem.num_rows());
  for (int i = 0; i < problem.num_contacts(); ++i) {
    const Eigen::Index n = i * d, t = n + 1;
    const double normal = s[n] - u[n];
    const double tangent = d > 1 ? s[t] - u[t] : 0;
    const double edge = problem.mu[i] * normal;
    if (normal <= 0) {
      point.set(problem, i, Cell::kTakeOff);
      point.value[n] = -normal;
      if (d > 1) point.value[t] = u[t];
    } else if (!problem.friction(i)) {
      point.set(problem, i, Cell::kSmooth);
      point.value[n] = normal;
      if (d > 1) point.value[t] = u[t];
    } else if (std::abs(tangent) <= edge) {
      point.set(problem, i, Cell::kStick);
      const double ratio = tangent / problem.mu[i];
      point.value[n] = 0.5 * (normal - ratio);
      point.value[t] = 0.5 * (normal + ratio);
    } else {
      point.set(problem, i, tangent < 0 ? Cell::kSlipPlus : Cell::kSlipMinus);
      point.value[n] = normal;
      point.value[t] = (std::abs(tangent) - edge) * (tangent < 0 ? 1 : -1);
    }
  }
  return point;
}

}  // namespace bipot
