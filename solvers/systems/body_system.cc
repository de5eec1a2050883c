#include "solvers/systems/body_system.h"

#include <algorithm>

#include "core/linear/block_pattern.h"
#include "core/problem/coulomb_cone.h"
#include "solvers/systems/body_pattern.h"

namespace bipot {
namespace {

/// Degrees of freedom that contact c acts on, ascending.
std::vector<int> touched_by(const ContactProblem& p, int c) {
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

std::vector<int> BodySystem::touched(const ContactProblem& problem) {
  const ContactsOfDofs contacts(problem);
  std::vector<int> dofs;
  for (int dof = 0; dof < problem.num_dofs(); ++dof) {
    if (contacts.start[to_size(dof)] < contacts.start[to_size(dof) + 1]) dofs.push_back(dof);
  }
  return dofs;
}

BodySystem::BodySystem(const ContactProblem& p, const std::vector<int>& dofs, const Vector& scale)
    : dim_(p.dim), contacts_(p.num_contacts()) {
  std::vector<int> unknown_of(to_size(p.num_dofs()), -1);
  for (std::size_t i = 0; i < dofs.size(); ++i) unknown_of[to_size(dofs[i])] = static_cast<int>(i);
  list_wrenches(p, unknown_of, scale);
  make_pattern(p, dofs);
  for (int i = 0; i < size(); ++i) {
    for (SparseMatrix::InnerIterator it(p.A, dofs[to_size(i)]); it; ++it) {
      const int row = unknown_of[to_size(it.row())];
      if (row < 0 || it.value() == 0) continue;
      mass_.push_back(it.value());
      mass_slot_.push_back(value_position(matrix_, row, i));
    }
  }
  list_runs();
}

/// Sets run_start_, run_end_ and slot_.
void BodySystem::list_runs() {
  run_start_.reserve(to_size(contacts_) + 1);
  run_start_.assign(1, 0);
  std::size_t slots = 0;
  for (int c = 0; c < contacts_; ++c) {
    const int begin = start_[to_size(c)], end = start_[to_size(c) + 1];
    for (int i = begin; i < end; ++i) {
      const bool last = i + 1 == end || unknown_[to_size(i) + 1] != unknown_[to_size(i)] + 1;
      if (last) run_end_.push_back(i + 1);
    }
    slots += to_size(end - begin) * (run_end_.size() - to_size(run_start_.back()));
    run_start_.push_back(static_cast<int>(run_end_.size()));
  }
  run_end_.shrink_to_fit();
  slot_.reserve(slots);
  for (int c = 0; c < contacts_; ++c) {
    for (int j = start_[to_size(c)]; j < start_[to_size(c) + 1]; ++j) {
      int first = start_[to_size(c)];
      for (int r = run_start_[to_size(c)]; r < run_start_[to_size(c) + 1]; ++r) {
        slot_.push_back(value_position(matrix_, unknown_[to_size(first)], unknown_[to_size(j)]));
        first = run_end_[to_size(r)];
      }
    }
  }
}

/// Sets start_, unknown_ and wrench_.
void BodySystem::list_wrenches(const ContactProblem& p, const std::vector<int>& unknown_of,
                               const Vector& scale) {
  const int d = dim_;
  start_.reserve(to_size(contacts_) + 1);
  start_.assign(1, 0);
  for (int c = 0; c < contacts_; ++c) {
    const std::vector<int> own = touched_by(p, c);
    const std::size_t first = unknown_.size();
    for (const int dof : own) unknown_.push_back(unknown_of[to_size(dof)]);
    wrench_.resize(unknown_.size() * to_size(d), 0.0);
    for (int a = 0; a < d; ++a) {
      for (SparseMatrix::InnerIterator it(p.H, c * d + a); it; ++it) {
        if (it.value() == 0) continue;
        const auto k = std::lower_bound(own.begin(), own.end(), it.row()) - own.begin();
        wrench_[(first + to_size(k)) * to_size(d) + to_size(a)] = it.value() * scale[c * d + a];
      }
    }
    start_.push_back(static_cast<int>(unknown_.size()));
  }
  unknown_.shrink_to_fit();
  wrench_.shrink_to_fit();
}

/// Sets matrix_ with zeros.
void BodySystem::make_pattern(const ContactProblem& p, const std::vector<int>& dofs) {
  const BodyPattern pattern(p, ContactsOfDofs(p), dofs);
  matrix_.resize(static_cast<Eigen::Index>(dofs.size()), static_cast<Eigen::Index>(dofs.size()));
  matrix_.resizeNonZeros(static_cast<Eigen::Index>(pattern.row.size()));
  std::copy(pattern.start.begin(), pattern.start.end(), matrix_.outerIndexPtr());
  std::copy(pattern.row.begin(), pattern.row.end(), matrix_.innerIndexPtr());
  std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
}

template <int D>
void BodySystem::add_contacts(const double* blocks) {
  double* const value = matrix_.valuePtr();
  const int* position = slot_.data();
  const int* const start = start_.data();
  const int* const run_start = run_start_.data();
  const int* const run_end = run_end_.data();
  const double* const G = wrench_.data();
  for (int c = 0; c < contacts_; ++c, blocks += D * D) {
    for (int j = start[c]; j < start[c + 1]; ++j) {
      Local<D> column = Local<D>::Zero();  // R (row j of G)ᵀ
      for (int a = 0; a < D; ++a) {
        for (int b = 0; b < D; ++b) column[a] += blocks[a * D + b] * G[j * D + b];
      }
      for (int r = run_start[c], i = start[c]; r < run_start[c + 1]; ++r) {
        double* to = value + *position++;
        for (; i < run_end[r]; ++i) {
          double sum = 0;
          for (int a = 0; a < D; ++a) sum += G[i * D + a] * column[a];
          *to++ += sum;
        }
      }
    }
  }
}

const SparseMatrix& BodySystem::assemble(const double* blocks) {
  double* const value = matrix_.valuePtr();
  std::fill(value, value + matrix_.nonZeros(), 0.0);
  for (std::size_t k = 0; k < mass_.size(); ++k) value[mass_slot_[k]] += mass_[k];
  dispatch_count(dim_, [&](auto d) { add_contacts<d()>(blocks); });
  return matrix_;
}

void BodySystem::momentum(const Vector& s, Vector& g) const {
  g.setZero(size());
  dispatch_count(dim_, [&](auto d) {
    constexpr int D = d();
    for (int c = 0; c < contacts_; ++c) {
      for (int i = start_[to_size(c)]; i < start_[to_size(c) + 1]; ++i) {
        double sum = 0;
        for (int a = 0; a < D; ++a) sum += wrench_[to_size(i * D + a)] * s[c * D + a];
        g[unknown_[to_size(i)]] += sum;
      }
    }
  });
}

void BodySystem::velocity(const Vector& v, Vector& u) const {
  u.resize(contacts_ * dim_);
  dispatch_count(dim_, [&](auto d) {
    constexpr int D = d();
    for (int c = 0; c < contacts_; ++c) {
      Local<D> sum = Local<D>::Zero();
      for (int i = start_[to_size(c)]; i < start_[to_size(c) + 1]; ++i) {
        const double speed = v[unknown_[to_size(i)]];
        for (int a = 0; a < D; ++a) sum[a] += wrench_[to_size(i * D + a)] * speed;
      }
      for (int a = 0; a < D; ++a) u[c * D + a] = sum[a];
    }
  });
}

}  // namespace bipot
