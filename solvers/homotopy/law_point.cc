#include "solvers/homotopy/law_point.h"

#include <algorithm>
#include <array>
#include <cmath>

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
  mu_r = scaling.mu_r;
  for (Vector* const coefficients : {&mu, &mu_r}) {
    for (double& x : *coefficients) {
      if (x < kNoFriction) x = 0;
    }
  }
}

void LawPoint::set(const LawProblem& problem, int contact, Cell to) {
  cell[to_size(contact)] = to;
  auto free = static_cast<unsigned>(to);
  const auto take = [&](Column c) {
    free &= ~(1U << static_cast<unsigned>(c));
    return c;
  };
  const auto next_ray = [&] {
    return take(ray(static_cast<unsigned>(std::countr_zero(rays(static_cast<Cell>(free))))));
  };
  Column* const first = &column[to_size(contact * problem.dim)];
  first[0] = has(to, Column::kOpening) ? Column::kOpening : next_ray();
  if (problem.dim > 1) {
    // Without sliding a ray on the other side of friction.
    const unsigned other = sides(first[0]) ^ 1;
    first[1] = has(to, Column::kSliding) ? Column::kSliding
               : has(to, ray(other))     ? take(ray(other))
                                         : take(ray(other ^ 2));
  }
  if (problem.dim > 2) first[2] = has(to, Column::kRolling) ? Column::kRolling : next_ray();
  find_bounds(problem, contact);
}

void LawPoint::find_bounds(const LawProblem& problem, int contact) {
  for (int slot = contact * problem.dim; slot < (contact + 1) * problem.dim; ++slot) {
    const Column c = column[to_size(slot)];
    const bool friction = (c == Column::kSliding && problem.bound(contact, 1) > 0) ||
                          (c == Column::kRolling && problem.bound(contact, 2) > 0);
    bound[slot] = bound_of(cell[to_size(contact)], c, friction);
  }
}

void LawPoint::find_bounds(const LawProblem& problem) {
  bound.resize(problem.num_rows());
  for (int i = 0; i < problem.num_contacts(); ++i) find_bounds(problem, i);
}

void LawPoint::sort_columns(const LawProblem& problem) {
  const int d = problem.dim;
  for (int i = 0; d > 1 && i < problem.num_contacts(); ++i) {
    std::array<Column, 3> before;
    std::array<double, 3> parameter;
    std::copy_n(column.begin() + i * d, d, before.begin());
    std::copy_n(value.begin() + i * d, d, parameter.begin());
    set(problem, i, cell[to_size(i)]);
    for (int k = 0; k < d; ++k) {
      const auto* const at =
          std::find(before.begin(), before.begin() + d, column[to_size(i * d + k)]);
      value[i * d + k] = parameter[to_size(static_cast<int>(at - before.begin()))];
    }
  }
}

Crossing LawPoint::across(const LawProblem& problem, int slot) const {
  const int d = problem.dim, contact = slot / d;
  unsigned slip = 0;
  for (int k = contact * d; k < (contact + 1) * d; ++k) {
    const Column c = column[to_size(k)];
    if (c == Column::kOpening || is_impulse(c) || !(value[k] < 0)) continue;
    const int row = c == Column::kSliding ? 1 : 2;
    if (problem.bound(contact, row) > 0) slip |= static_cast<unsigned>(row);
  }
  return cross(cell[to_size(contact)], column[to_size(slot)], slip);
}

void LawPoint::impulse(const LawProblem& problem, Vector& s) const {
  s.setZero(problem.num_rows());
  for (Eigen::Index slot = 0; slot < value.size(); ++slot) {
    const Column kind = column[to_size(slot)];
    if (!is_impulse(kind)) continue;
    const int contact = static_cast<int>(slot) / problem.dim;
    const Eigen::Index row = contact * problem.dim;
    s[row] += value[slot];
    for (int k = 1; k < problem.dim; ++k) {
      s[row + k] += problem.tangent(contact, kind, k) * value[slot];
    }
  }
}

void LawPoint::velocity(const LawProblem& problem, Vector& u) const {
  u.setZero(problem.num_rows());
  for (Eigen::Index slot = 0; slot < value.size(); ++slot) {
    const Column kind = column[to_size(slot)];
    const Eigen::Index row = slot / problem.dim * problem.dim;
    if (kind == Column::kOpening) u[row] = value[slot];
    if (kind == Column::kSliding) u[row + 1] = value[slot];
    if (kind == Column::kRolling) u[row + 2] = value[slot];
  }
}

LawPoint nearest_point(const LawProblem& problem, const Vector& s, const Vector& u) {
  const int d = problem.dim;
  LawPoint point;
  point.cell.resize(to_size(problem.num_contacts()));
  point.column.resize(to_size(problem.num_rows()));
  point.bound.resize(problem.num_rows());
  point.value.resize(problem.num_rows());
  for (int i = 0; i < problem.num_contacts(); ++i) {
    const Eigen::Index n = i * d;
    const double normal = s[n] - u[n];
    if (normal <= 0) {
      point.set(problem, i, Cell::kTakeOff);
      point.value[n] = -normal;
      for (int k = 1; k < d; ++k) point.value[n + k] = u[n + k];
      continue;
    }
    // Of each row: the impulse over its bound, the velocity, and whether that is free.
    double ratio[] = {0, -normal, -normal}, slip[] = {0, 0, 0};
    bool sticks[] = {false, false, false};
    unsigned side = 0;
    for (int k = 1; k < d; ++k) {
      const double bound = problem.bound(i, k), edge = bound * normal;
      const double tangent = s[n + k] - u[n + k];
      if (bound == 0) {
        slip[k] = u[n + k];
      } else if (std::abs(tangent) <= edge) {
        sticks[k] = true;
        ratio[k] = tangent / bound;
      } else {
        slip[k] = (std::abs(tangent) - edge) * (tangent < 0 ? 1 : -1);
        if (tangent > 0) side |= static_cast<unsigned>(k);
      }
    }
    // The rays between which the impulse lies: from a corner of the cone to the opposite one.
    const auto bit = [](unsigned sides) { return 1U << static_cast<unsigned>(ray(sides)); };
    unsigned cell = bit(side);
    for (unsigned k : {1U, 2U}) cell |= sticks[k] ? bit(side | k) : 0;
    const bool both = sticks[1] && sticks[2];
    if (both) cell = bit(0) | bit(3) | bit(ratio[1] >= ratio[2] ? 1 : 2);
    if (!sticks[1]) cell |= 1U << static_cast<unsigned>(Column::kSliding);
    if (!sticks[2]) cell |= 1U << static_cast<unsigned>(Column::kRolling);
    point.set(problem, i, static_cast<Cell>(cell));
    for (int k = 0; k < d; ++k) {
      const Column c = point.column[to_size(static_cast<int>(n) + k)];
      double& value = point.value[n + k];
      if (c == Column::kSliding || c == Column::kRolling) {
        value = slip[c == Column::kSliding ? 1 : 2];
      } else if (both) {
        const double low = std::min(ratio[1], ratio[2]), high = std::max(ratio[1], ratio[2]);
        value = 0.5 * (c == ray(0) ? normal - high : c == ray(3) ? normal + low : high - low);
      } else {
        const int row = sticks[1] ? 1 : 2;
        const bool plus = (sides(c) & static_cast<unsigned>(row)) == 0;
        value = !sticks[row] ? normal : 0.5 * (plus ? normal - ratio[row] : normal + ratio[row]);
      }
    }
  }
  return point;
}

}  // namespace bipot
