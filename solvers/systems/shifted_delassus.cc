#include "solvers/systems/shifted_delassus.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/linear/block_pattern.h"

namespace bipot {

ShiftedDelassus::ShiftedDelassus(const ContactProblem& problem, Form form, SystemFactor* elsewhere,
                                 FactorStop stop)
    : problem_(problem), factor_(elsewhere), stop_(std::move(stop)) {
  const bool can_body = problem.has_velocities() && is_diagonal(problem.A);
  if (form == Form::kBody && !can_body) {
    throw std::invalid_argument("the body form needs H and a diagonal A");
  }
  std::vector<int> dofs;
  if (can_body && form != Form::kContact) dofs = BodySystem::touched(problem);
  body_form_ = can_body && form != Form::kContact &&
               (form == Form::kBody || static_cast<int>(dofs.size()) <= 2 * problem.num_rows());
  if (body_form_) {
    body_.emplace(problem, dofs, Vector::Ones(problem.num_rows()));
  } else {
    build_contact_pattern();
  }
  if (factor_ != nullptr) return;
  here_ = std::make_unique<LocalFactor>(
      body_form_ ? SparseLU::Strategy::kSymmetric : SparseLU::Strategy::kAuto, stop_);
  factor_ = here_.get();
}

void ShiftedDelassus::build_contact_pattern() {
  const ContactProblem& p = problem_;
  const int d = p.dim;
  if (!p.has_delassus()) own_delassus_ = assemble_delassus(p.A, p.H, d);
  const SparseRows& W = p.has_delassus() ? p.W : own_delassus_;
  matrix_ = symmetric_block_pattern(W.transpose(), d);
  row_start_.assign(1, 0);
  for (int c = 0; c < p.num_contacts(); ++c) {
    // The pattern is symmetric: the columns of a row are the rows of its column.
    const int* const begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[c * d];
    const int* const end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[c * d + 1];
    const std::size_t first = to_size(row_start_.back());
    row_block_.resize((first + to_size(end - begin)) * to_size(d), 0.0);
    for (int a = 0; a < d; ++a) {
      for (SparseRows::InnerIterator it(W, c * d + a); it; ++it) {
        const auto k = std::lower_bound(begin, end, it.col()) - begin;
        row_block_[(first + to_size(k)) * to_size(d) + to_size(a)] += it.value();
      }
    }
    for (const int* column = begin; column != end; ++column) {
      const int block = value_position(matrix_, c * d, *column);
      for (int a = 0; a < d; ++a) row_slot_.push_back(block + a);
    }
    row_start_.push_back(row_start_.back() + static_cast<int>(end - begin));
  }
}

void ShiftedDelassus::assemble_contact_form() {
  const int d = problem_.dim;
  double* const value = matrix_.valuePtr();
  std::fill(value, value + matrix_.nonZeros(), 0.0);
  const int* start = row_start_.data();
  const int* position = row_slot_.data();
  const double* W = row_block_.data();
  const double* block = R_.data();
  for (int c = 0; c < problem_.num_contacts(); ++c, block += d * d) {
    for (int k = start[c]; k < start[c + 1]; ++k) {
      for (int a = 0; a < d; ++a) {
        double sum = 0;
        for (int b = 0; b < d; ++b) sum += block[a * d + b] * W[k * d + b];
        value[position[k * d + a]] = sum;
      }
    }
  }
  for (int i = 0; i < problem_.num_rows(); ++i) matrix_.coeffRef(i, i) += 1;
}

bool ShiftedDelassus::factor(const std::vector<double>& R) {
  stop_.ask();
  R_ = R;
  if (body_form_) {
    body_->assemble(R_.data());
  } else {
    assemble_contact_form();
  }
  const SparseMatrix& K = matrix();
  if (!Eigen::Map<const Vector>(K.valuePtr(), K.nonZeros()).allFinite()) return false;
  return factor_->factor(K);
}

void ShiftedDelassus::solve(const Vector& g, Vector& x) const {
  if (!body_form_) {
    factor_->solve(g, x);
    return;
  }
  const int d = problem_.dim;
  body_->momentum(g, wrench_);
  factor_->solve(wrench_, velocity_);
  body_->velocity(velocity_, change_);
  x = g;
  const double* block = R_.data();
  for (int c = 0; c < problem_.num_contacts(); ++c, block += d * d) {
    for (int a = 0; a < d; ++a) {
      for (int b = 0; b < d; ++b) x[c * d + a] -= block[a * d + b] * change_[c * d + b];
    }
  }
}

}  // namespace bipot
