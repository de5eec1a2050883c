#include "solvers/kernels/shifted_delassus.h"

#include <algorithm>
#include <stdexcept>

#include "core/problem/block_pattern.h"

namespace bipot {
namespace {

/// Position of (row, col) in a compressed column matrix whose pattern holds it.
int slot(const SparseMatrix& matrix, int row, int col) {
  const int* begin = matrix.innerIndexPtr() + matrix.outerIndexPtr()[col];
  const int* end = matrix.innerIndexPtr() + matrix.outerIndexPtr()[col + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - matrix.innerIndexPtr());
}

/// Degrees of freedom that contact c acts on, sorted.
std::vector<int> touched(const ContactProblem& p, int c) {
  std::vector<int> dofs;
  for (int a = 0; a < p.dim; ++a) {
    for (SparseMatrix::InnerIterator it(p.H, c * p.dim + a); it; ++it) {
      if (it.value() != 0) dofs.push_back(static_cast<int>(it.row()));
    }
  }
  std::sort(dofs.begin(), dofs.end());
  dofs.erase(std::unique(dofs.begin(), dofs.end()), dofs.end());
  return dofs;
}

}  // namespace

ShiftedDelassus::ShiftedDelassus(const ContactProblem& problem, Form form, SystemFactor* elsewhere)
    : problem_(problem), factor_(elsewhere) {
  const bool can_body = problem.has_velocities() && is_diagonal(problem.A);
  if (form == Form::kBody && !can_body) {
    throw std::invalid_argument("the body form needs H and a diagonal A");
  }
  int unknowns = 0;
  if (can_body && form != Form::kContact) {
    std::vector<char> used(to_size(problem.num_dofs()), 0);
    for (int c = 0; c < problem.num_contacts(); ++c) {
      for (int dof : touched(problem, c)) used[to_size(dof)] = 1;
    }
    unknown_of_dof_.assign(to_size(problem.num_dofs()), -1);
    for (int dof = 0; dof < problem.num_dofs(); ++dof) {
      if (used[to_size(dof)]) unknown_of_dof_[to_size(dof)] = unknowns++;
    }
  }
  body_form_ = can_body && form != Form::kContact &&
               (form == Form::kBody || unknowns <= 2 * problem.num_rows());
  if (body_form_) {
    build_body_pattern();
  } else {
    build_contact_pattern();
  }
  if (factor_ != nullptr) return;
  here_ = std::make_unique<LocalFactor>(body_form_ ? SparseLU::Strategy::kSymmetric
                                                   : SparseLU::Strategy::kAuto);
  factor_ = here_.get();
}

ShiftedDelassus::~ShiftedDelassus() = default;

void ShiftedDelassus::build_body_pattern() {
  const ContactProblem& p = problem_;
  const int d = p.dim;
  const Vector masses = p.A.diagonal();
  for (int dof = 0; dof < p.num_dofs(); ++dof) {
    if (unknown_of_dof_[to_size(dof)] >= 0) mass_.push_back(masses[dof]);
  }
  const int n = static_cast<int>(mass_.size());
  body_start_.assign(1, 0);
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) entries.emplace_back(i, i, 0.0);
  for (int c = 0; c < p.num_contacts(); ++c) {
    const std::vector<int> dofs = touched(p, c);
    const std::size_t first = body_unknown_.size();
    for (int dof : dofs) body_unknown_.push_back(unknown_of_dof_[to_size(dof)]);
    body_wrench_.resize(body_unknown_.size() * to_size(d), 0.0);
    for (int a = 0; a < d; ++a) {
      for (SparseMatrix::InnerIterator it(p.H, c * d + a); it; ++it) {
        if (it.value() == 0) continue;
        const auto k = std::lower_bound(dofs.begin(), dofs.end(), it.row()) - dofs.begin();
        body_wrench_[(first + to_size(k)) * to_size(d) + to_size(a)] = it.value();
      }
    }
    for (std::size_t i = first; i < body_unknown_.size(); ++i) {
      for (std::size_t j = first; j < body_unknown_.size(); ++j) {
        entries.emplace_back(body_unknown_[i], body_unknown_[j], 0.0);
      }
    }
    body_start_.push_back(static_cast<int>(body_unknown_.size()));
  }
  matrix_.resize(n, n);
  matrix_.setFromTriplets(entries.begin(), entries.end());
  matrix_.makeCompressed();
  for (int i = 0; i < n; ++i) diagonal_slot_.push_back(slot(matrix_, i, i));
  for (std::size_t c = 0; c + 1 < body_start_.size(); ++c) {
    for (int j = body_start_[c]; j < body_start_[c + 1]; ++j) {
      for (int i = body_start_[c]; i < body_start_[c + 1]; ++i) {
        body_slot_.push_back(slot(matrix_, body_unknown_[to_size(i)], body_unknown_[to_size(j)]));
      }
    }
  }
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
      const int block = slot(matrix_, c * d, *column);
      for (int a = 0; a < d; ++a) row_slot_.push_back(block + a);
    }
    row_start_.push_back(row_start_.back() + static_cast<int>(end - begin));
  }
}

bool ShiftedDelassus::factor(const std::vector<double>& R) {
  const int d = problem_.dim;
  R_ = R;
  double* value = matrix_.valuePtr();
  const double* block = R_.data();
  std::fill(value, value + matrix_.nonZeros(), 0.0);
  if (body_form_) {
    for (std::size_t i = 0; i < mass_.size(); ++i) value[diagonal_slot_[i]] = mass_[i];
    const int* position = body_slot_.data();
    const int* start = body_start_.data();
    const double* H = body_wrench_.data();
    for (int c = 0; c < problem_.num_contacts(); ++c, block += d * d) {
      for (int j = start[c]; j < start[c + 1]; ++j) {
        double column[3] = {0, 0, 0};  // R (row j of H)ᵀ
        for (int a = 0; a < d; ++a) {
          for (int b = 0; b < d; ++b) column[a] += block[a * d + b] * H[j * d + b];
        }
        for (int i = start[c]; i < start[c + 1]; ++i) {
          double sum = 0;
          for (int a = 0; a < d; ++a) sum += H[i * d + a] * column[a];
          value[*position++] += sum;
        }
      }
    }
  } else {
    const int* start = row_start_.data();
    const int* position = row_slot_.data();
    const double* W = row_block_.data();
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
  if (!Eigen::Map<const Vector>(value, matrix_.nonZeros()).allFinite()) return false;
  return factor_->factor(matrix_);
}

void ShiftedDelassus::solve(const Vector& g, Vector& x) const {
  if (!body_form_) {
    factor_->solve(g, x);
    return;
  }
  const int d = problem_.dim;
  const int* start = body_start_.data();
  const int* unknown = body_unknown_.data();
  const double* H = body_wrench_.data();
  const double* block = R_.data();
  wrench_.setZero(static_cast<Eigen::Index>(mass_.size()));
  for (int c = 0; c < problem_.num_contacts(); ++c) {
    for (int i = start[c]; i < start[c + 1]; ++i) {
      double sum = 0;
      for (int a = 0; a < d; ++a) sum += H[i * d + a] * g[c * d + a];
      wrench_[unknown[i]] += sum;
    }
  }
  factor_->solve(wrench_, velocity_);
  x = g;
  for (int c = 0; c < problem_.num_contacts(); ++c, block += d * d) {
    double du[3] = {0, 0, 0};
    for (int i = start[c]; i < start[c + 1]; ++i) {
      for (int a = 0; a < d; ++a) du[a] += H[i * d + a] * velocity_[unknown[i]];
    }
    for (int a = 0; a < d; ++a) {
      for (int b = 0; b < d; ++b) x[c * d + a] -= block[a * d + b] * du[b];
    }
  }
}

}  // namespace bipot
