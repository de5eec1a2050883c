#include "solvers/homotopy/cell_basis.h"

#include <algorithm>

#include "core/base/release.h"
#include "core/linear/block_pattern.h"

namespace bipot {
namespace {

// Kinds of columns of a contact.
constexpr int kColumns = 4;
// Fronts exchange rows within themselves alone. A factor with larger multipliers is rejected.
constexpr double kLargestMultiplier = 1e8;
// Fewer candidates are solved for one by one.
constexpr std::size_t kFewCandidates = 3;
// Refinement with a factor in single precision: rounds at most, and the error, relative to the
// solution, at which it ends.
constexpr int kRounds = 10;
constexpr double kRefined = 1e-10;
// Columns that are kept then.
constexpr int kBytesInSingle = 5 << 19, kLeastInSingle = 16;

}  // namespace

CellBasis::CellBasis(const LawProblem& problem, Precision precision)
    : problem_(problem),
      matrix_(problem),
      precision_(problem.bodies ? Precision::kSingle : precision),
      exchanged_(in_single() ? ExchangedColumns(kBytesInSingle, kLeastInSingle, true)
                             : ExchangedColumns()) {
  rhs_.setZero(problem.num_rows());
  if (problem.bodies) velocities_.emplace(problem);
}

bool CellBasis::factor(const LawPoint& point, const Vector& proximal) {
  matrix_.set(point.column, proximal);
  exchanged_.clear(problem_.num_rows(), kColumns * problem_.num_contacts());
  if (velocities_) {
    return_freed_memory();  // releases the columns before the factor's own arrays are allocated
    return velocities_->factor(matrix_.columns(), matrix_.proximal());
  }
  if (!analysed_) {
    const SparseMatrix pattern = symmetric_block_pattern(problem_.W, problem_.dim);
    analysed_ = in_single() ? single_fronts_.analyse(pattern) : fronts_.analyse(pattern);
  }
  if (in_single()) return analysed_ && single_fronts_.factor(matrix_);
  by_fronts_ =
      analysed_ && fronts_.factor(matrix_) && fronts_.largest_multiplier() <= kLargestMultiplier;
  return by_fronts_ || factor_with_exchanges(point);
}

void CellBasis::rest() {
  if (in_single()) exchanged_.clear(problem_.num_rows(), kColumns * problem_.num_contacts());
}

bool CellBasis::factor_with_exchanges(const LawPoint& point) {
  if (!rows_exchanged_) {
    rows_exchanged_.emplace(fill_reducing_order(problem_.W, problem_.dim));
  }
  SparseColumns& matrix = rows_exchanged_->matrix();
  matrix.clear();
  for (int slot = 0; slot < problem_.num_rows(); ++slot) {
    matrix_.for_column(slot / problem_.dim, point.column[to_size(slot)],
                       [&](int row, double value) { matrix.add(row, value); });
    matrix.end_column();
  }
  return rows_exchanged_->factor();
}

void CellBasis::solve_factored(const Vector& g, Vector& x) {
  if (in_single()) {
    solve_in_single(g, x);
  } else if (by_fronts_) {
    fronts_.solve(g, x);
  } else {
    rows_exchanged_->solve(g, x);
  }
}

void CellBasis::solve_in_single(const Vector& g, Vector& x) {
  const auto solve = [this](const Vector& right, Vector& solution) {
    velocities_ ? velocities_->solve(right, solution) : single_fronts_.solve(right, solution);
  };
  solve(g, x);
  double before = x.lpNorm<Eigen::Infinity>();
  for (int round = 0; round < kRounds; ++round) {
    matrix_.rough_residual(g, x, rest_);
    solve(rest_, correction_);
    x += correction_;
    const double size = x.lpNorm<Eigen::Infinity>(), now = correction_.lpNorm<Eigen::Infinity>();
    // Corrections decrease by a constant factor, so that the next would be about now² / before.
    if (now * now <= kRefined * size * before) return;
    before = now;
  }
  x.setConstant(kNaN);
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
  const std::vector<Column>& factored = matrix_.columns();
  return factored[to_size(c.slot)] != c.column && factored[to_size(other)] != c.column &&
         exchanged_.find(key(c.contact, c.column)) < 0;
}

void CellBasis::prepare(const std::vector<Candidate>& candidates) {
  // A few single solves skip fronts that they do not reach.
  if (in_single() || !by_fronts_ || candidates.size() < kFewCandidates) return;
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
  const int d = problem_.dim;
  if (matrix_.columns()[to_size(slot)] == column) {
    result.pivot = exchanged_.own_entry(slot);
    return result;
  }
  const int name = key(contact, column);
  result.number = exchanged_.find(name);
  if (result.number < 0) {
    const int other = d == 1 ? slot : slot ^ 1;
    if (matrix_.columns()[to_size(other)] == column) {
      y_.setZero(problem_.num_rows());
      y_[other] = 1;
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
  if (velocities_) return velocities_->orientation();
  const int sign = in_single()  ? single_fronts_.determinant_sign()
                   : by_fronts_ ? fronts_.determinant_sign()
                                : rows_exchanged_->determinant_sign();
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
  if (velocities_) error_ = change_ = Vector();  // where memory counts
}

}  // namespace bipot
