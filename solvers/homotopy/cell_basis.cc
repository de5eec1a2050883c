#include "solvers/homotopy/cell_basis.h"

#include <algorithm>

#include "core/linear/block_pattern.h"

namespace bipot {
namespace {

// Fronts exchange rows within themselves alone. A factor with larger multipliers is rejected.
constexpr double kLargestMultiplier = 1e8;
// Fewer candidates are solved for one by one.
constexpr std::size_t kFewCandidates = 3;

}  // namespace

CellBasis::CellBasis(const LawProblem& problem, const FactorStop& stop)
    : problem_(problem), matrix_(problem), stop_(stop) {
  fronts_.stop_by(stop);
  rhs_.setZero(problem.num_rows());
}

bool CellBasis::factor(const LawPoint& point, const Vector& proximal) {
  matrix_.set(point.column, proximal);
  exchanged_.clear(problem_.num_rows(), kColumns * problem_.num_contacts());
  if (!analysed_) fronts_.analyse(symmetric_block_pattern(problem_.W, problem_.dim));
  analysed_ = true;
  by_fronts_ = fronts_.factor(matrix_) && fronts_.largest_multiplier() <= kLargestMultiplier;
  return by_fronts_ || factor_with_exchanges();
}

bool CellBasis::factor_with_exchanges() {
  stop_.ask();
  const int m = problem_.num_rows();
  SparseMatrix B(m, m);
  for (int slot = 0; slot < m; ++slot) {
    B.startVec(slot);
    matrix_.for_column(slot / problem_.dim, matrix_.columns()[to_size(slot)],
                       [&](int row, double value) { B.insertBack(row, slot) = value; });
  }
  B.finalize();
  return rows_exchanged_.factor(B);
}

void CellBasis::solve_factored(const Vector& g, Vector& x) {
  if (by_fronts_) {
    fronts_.solve(g, x);
  } else {
    x = rows_exchanged_.solve(g);
  }
}

void CellBasis::solve(const Vector& g, Vector& x) {
  solve_factored(g, x);
  exchanged_.apply(x);
}

int CellBasis::key(int contact, Column column) {
  return kColumns * contact + static_cast<int>(column);
}

int CellBasis::factored_slot(int contact, Column column) const {
  const Column* const first = &matrix_.columns()[to_size(contact * problem_.dim)];
  const Column* const end = first + problem_.dim;
  const Column* const at = std::find(first, end, column);
  return at == end ? -1 : contact * problem_.dim + static_cast<int>(at - first);
}

bool CellBasis::is_unknown(const Candidate& c) const {
  return factored_slot(c.contact, c.column) < 0 && exchanged_.find(key(c.contact, c.column)) < 0;
}

void CellBasis::prepare(const std::vector<Candidate>& candidates) {
  // A few single solves skip fronts that they do not reach.
  if (!by_fronts_ || candidates.size() < kFewCandidates) return;
  several_.clear();
  for (const Candidate& c : candidates) {
    matrix_.for_column(c.contact, c.column,
                       [&](int row, double value) { several_.add(row, value); });
    several_.end_column();
  }
  fronts_.solve(several_, solutions_.data());
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    exchanged_.keep(key(candidates[k].contact, candidates[k].column), solutions_[k]);
  }
}

CellBasis::Entering CellBasis::entering(int contact, Column column, int slot) {
  Entering result{slot, -1, 0, 1};
  const int factored = factored_slot(contact, column);
  if (factored == slot) {
    result.pivot = exchanged_.own_entry(slot);
    return result;
  }
  const int name = key(contact, column);
  result.number = exchanged_.find(name);
  if (result.number < 0) {
    if (factored >= 0) {
      y_.setZero(problem_.num_rows());
      y_[factored] = 1;
    } else {
      matrix_.for_column(contact, column, [&](int row, double value) { rhs_[row] = value; });
      solve_factored(rhs_, y_);
      matrix_.for_column(contact, column, [&](int row, double) { rhs_[row] = 0; });
    }
    result.number = exchanged_.keep(name, y_);
  }
  result.pivot = exchanged_.entry(result.number, slot);
  result.size = exchanged_.size(result.number);
  return result;
}

int CellBasis::orientation(const LawPoint& point) const {
  const auto impulses = std::count_if(point.column.begin(), point.column.end(), is_impulse);
  const int sign = by_fronts_ ? fronts_.determinant_sign() : rows_exchanged_.determinant_sign();
  return sign * (impulses % 2 == 0 ? 1 : -1);
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
    matrix_.residual(point.column, g, weight, h, x, error_);
    solve(error_, change_);
    x += change_;
  }
}

}  // namespace bipot
