#include "solvers/homotopy/cell_basis.h"

#include <algorithm>
#include <limits>

#include "core/problem/block_pattern.h"

namespace bipot {
namespace {

// Kinds of columns that a contact has.
constexpr int kColumns = 4;
// Fronts exchange rows among themselves only. With larger multipliers their factor is left: ten
// thousand cells of poured packings stay below 1e6.
constexpr double kLargestMultiplier = 1e8;
// Candidates below that number are solved for one by one.
constexpr std::size_t kFewCandidates = 3;

/// Nothing where they are W's columns, to the last bit.
SparseRows rows_unless_symmetric(const SparseMatrix& W) {
  SparseRows rows(W);
  const bool same =
      std::equal(rows.outerIndexPtr(), rows.outerIndexPtr() + W.cols() + 1, W.outerIndexPtr()) &&
      std::equal(rows.innerIndexPtr(), rows.innerIndexPtr() + W.nonZeros(), W.innerIndexPtr()) &&
      std::equal(rows.valuePtr(), rows.valuePtr() + W.nonZeros(), W.valuePtr());
  return same ? SparseRows() : rows;
}

}  // namespace

CellBasis::CellBasis(const LawProblem& problem)
    : problem_(problem),
      rows_(rows_unless_symmetric(problem.W)),
      matrix_(symmetric_block_pattern(problem.W, problem.dim)) {
  rhs_.setZero(problem.num_rows());
}

/// Calls add(row, value), rows ascending.
template <class Add>
void CellBasis::for_column(int contact, Column column, Add&& add) const {
  const int d = problem_.dim, n = contact * d;
  if (!is_impulse(column)) {
    add(column == Column::kOpening ? n : n + 1, 1.0);
    return;
  }
  const double tangent = problem_.tangent(contact, column);
  SparseMatrix::InnerIterator a(problem_.W, n);
  if (d == 1) {
    for (; a; ++a) add(static_cast<int>(a.row()), -a.value() - (a.row() == n ? proximal_[n] : 0));
    return;
  }
  constexpr int kEnd = std::numeric_limits<int>::max();
  SparseMatrix::InnerIterator b(problem_.W, n + 1);
  while (a || b) {
    const int row_a = a ? static_cast<int>(a.row()) : kEnd;
    const int row_b = b ? static_cast<int>(b.row()) : kEnd;
    const int row = std::min(row_a, row_b);
    double value = 0;
    if (row_a == row) {
      value -= a.value();
      ++a;
    }
    if (row_b == row) {
      value -= tangent * b.value();
      ++b;
    }
    if (row == n) value -= proximal_[n];
    if (row == n + 1) value -= tangent * proximal_[n + 1];
    add(row, value);
  }
}

bool CellBasis::factor(const LawPoint& point, const Vector& proximal) {
  proximal_ = proximal;
  factored_ = point.column;
  exchanged_.clear(problem_.num_rows(), kColumns * problem_.num_contacts());
  const int* const start = matrix_.outerIndexPtr();
  const int* const row_of = matrix_.innerIndexPtr();
  double* const values = matrix_.valuePtr();
  for (int slot = 0; slot < problem_.num_rows(); ++slot) {
    int k = start[slot];
    std::fill(values + k, values + start[slot + 1], 0.0);
    for_column(slot / problem_.dim, point.column[to_size(slot)], [&](int row, double value) {
      while (row_of[k] < row) ++k;
      values[k] = value;
    });
  }
  by_fronts_ = fronts_.factor(matrix_) && fronts_.largest_multiplier() <= kLargestMultiplier;
  return by_fronts_ || factor_with_exchanges(point);
}

bool CellBasis::factor_with_exchanges(const LawPoint& point) {
  if (!rows_exchanged_) {
    rows_exchanged_.emplace(fill_reducing_order(problem_.W, problem_.dim));
  }
  SparseColumns& matrix = rows_exchanged_->matrix();
  matrix.clear();
  for (int slot = 0; slot < problem_.num_rows(); ++slot) {
    for_column(slot / problem_.dim, point.column[to_size(slot)],
               [&](int row, double value) { matrix.add(row, value); });
    matrix.end_column();
  }
  return rows_exchanged_->factor();
}

void CellBasis::solve_factored(const Vector& g, Vector& x) const {
  if (by_fronts_) {
    fronts_.solve(g, x);
  } else {
    rows_exchanged_->solve(g, x);
  }
}

void CellBasis::solve(const Vector& g, Vector& x) {
  solve_factored(g, x);
  exchanged_.apply(x);
}

int CellBasis::key(int contact, Column column) {
  return kColumns * contact + static_cast<int>(column);
}

bool CellBasis::is_unknown(const Candidate& c) const {
  const int other = problem_.dim == 1 ? c.slot : c.slot ^ 1;
  return factored_[to_size(c.slot)] != c.column && factored_[to_size(other)] != c.column &&
         exchanged_.find(key(c.contact, c.column)) < 0;
}

void CellBasis::prepare(const std::vector<Candidate>& candidates) {
  // Fewer solves one after the other pass over fronts that they do not reach.
  if (!by_fronts_ || candidates.size() < kFewCandidates) return;
  several_.clear();
  for (const Candidate& c : candidates) {
    for_column(c.contact, c.column, [&](int row, double value) { several_.add(row, value); });
    several_.end_column();
  }
  fronts_.solve(several_, solutions_.data());
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    exchanged_.keep(key(candidates[k].contact, candidates[k].column), solutions_[k]);
  }
}

CellBasis::Entering CellBasis::entering(int contact, Column column, int slot) {
  Entering result{slot, -1, 0, 1};
  const int d = problem_.dim;
  if (factored_[to_size(slot)] == column) {
    result.pivot = exchanged_.own_entry(slot);
    return result;
  }
  const int name = key(contact, column);
  result.number = exchanged_.find(name);
  if (result.number < 0) {
    const int other = d == 1 ? slot : slot ^ 1;
    if (factored_[to_size(other)] == column) {
      y_.setZero(problem_.num_rows());
      y_[other] = 1;
    } else {
      for_column(contact, column, [&](int row, double value) { rhs_[row] = value; });
      solve_factored(rhs_, y_);
      for_column(contact, column, [&](int row, double) { rhs_[row] = 0; });
    }
    result.number = exchanged_.keep(name, y_);
  }
  result.pivot = exchanged_.entry(result.number, slot);
  result.size = exchanged_.size(result.number);
  return result;
}

int CellBasis::orientation(const LawPoint& point) const {
  const auto impulses = std::count_if(point.column.begin(), point.column.end(), is_impulse);
  const int sign = by_fronts_ ? fronts_.determinant_sign() : rows_exchanged_->determinant_sign();
  return sign * (impulses % 2 == 0 ? 1 : -1);
}

/// out = g + weight h - B x. The impulse is taken together in extended precision, as mu times a
/// parameter is not a double, and multiplied row by row: sums of 80 bits stay in registers.
void CellBasis::residual(const LawPoint& point, const Vector& g, long double weight,
                         const Vector& h, const Vector& x, Vector& out) {
  const int d = problem_.dim, m = problem_.num_rows();
  sum_.resize(to_size(m));
  impulse_.assign(to_size(m), 0);
  long double* const sum = sum_.data();
  long double* const impulse = impulse_.data();
  for (int i = 0; i < m; ++i) sum[i] = static_cast<long double>(g[i]) + weight * h[i];
  for (int slot = 0; slot < m; ++slot) {
    const long double value = x[slot];
    const Column column = point.column[to_size(slot)];
    const int contact = slot / d, n = contact * d;
    if (column == Column::kOpening) {
      sum[n] -= value;
    } else if (column == Column::kSliding) {
      sum[n + 1] -= value;
    } else {
      impulse[n] += value;
      if (d > 1) impulse[n + 1] += problem_.tangent(contact, column) * value;
    }
  }
  out.resize(m);
  const bool symmetric = rows_.rows() == 0;
  const int* const start = symmetric ? problem_.W.outerIndexPtr() : rows_.outerIndexPtr();
  const int* const column = symmetric ? problem_.W.innerIndexPtr() : rows_.innerIndexPtr();
  const double* const w = symmetric ? problem_.W.valuePtr() : rows_.valuePtr();
  for (int i = 0; i < m; ++i) {
    long double even = sum[i] + proximal_[i] * impulse[i], odd = 0;
    int k = start[i];
    for (; k + 1 < start[i + 1]; k += 2) {
      even += w[k] * impulse[column[k]];
      odd += w[k + 1] * impulse[column[k + 1]];
    }
    if (k < start[i + 1]) even += w[k] * impulse[column[k]];
    out[i] = static_cast<double>(even + odd);
  }
}

void CellBasis::solve_refined(const LawPoint& point, const Vector& g, long double weight,
                              const Vector& h, int refinements, Vector& x) {
  change_ = g + static_cast<double>(weight) * h;
  solve(change_, x);
  refine(point, g, weight, h, refinements, x);
}

void CellBasis::refine(const LawPoint& point, const Vector& g, long double weight, const Vector& h,
                       int refinements, Vector& x) {
  for (int k = 0; k < refinements; ++k) {
    residual(point, g, weight, h, x, error_);
    solve(error_, change_);
    x += change_;
  }
}

}  // namespace bipot
