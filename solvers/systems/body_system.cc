#include "solvers/systems/body_system.h"

#include <algorithm>

#include "core/linear/block_pattern.h"
#include "core/problem/coulomb_cone.h"
#include "solvers/systems/body_pattern.h"

namespace bipot {

std::vector<int> BodySystem::touched(const ContactProblem& problem) {
  const Lists<> contacts = contacts_of_dofs(problem);
  std::vector<int> dofs;
  for (int dof = 0; dof < problem.num_dofs(); ++dof) {
    if (!contacts.of(dof).empty()) dofs.push_back(dof);
  }
  return dofs;
}

BodySystem::BodySystem(const ContactProblem& p, const std::vector<int>& dofs, const Vector& scale)
    : dim_(p.dim), wrenches_(p.H, p.dim, scale) {
  std::vector<int> unknown_of(to_size(p.num_dofs()), -1);
  for (std::size_t i = 0; i < dofs.size(); ++i) unknown_of[to_size(dofs[i])] = static_cast<int>(i);
  wrenches_.renumber(unknown_of);
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
  const ContactWrenches& w = wrenches_;
  run_start_.reserve(to_size(w.num_contacts()) + 1);
  run_start_.assign(1, 0);
  std::size_t slots = 0;
  for (int c = 0; c < w.num_contacts(); ++c) {
    for (int i = w.begin(c); i < w.end(c); ++i) {
      const bool last = i + 1 == w.end(c) || w.dof(i + 1) != w.dof(i) + 1;
      if (last) run_end_.push_back(i + 1);
    }
    slots += to_size(w.end(c) - w.begin(c)) * (run_end_.size() - to_size(run_start_.back()));
    run_start_.push_back(static_cast<int>(run_end_.size()));
  }
  run_end_.shrink_to_fit();
  slot_.reserve(slots);
  for (int c = 0; c < w.num_contacts(); ++c) {
    for (int j = w.begin(c); j < w.end(c); ++j) {
      int first = w.begin(c);
      for (int r = run_start_[to_size(c)]; r < run_start_[to_size(c) + 1]; ++r) {
        slot_.push_back(value_position(matrix_, w.dof(first), w.dof(j)));
        first = run_end_[to_size(r)];
      }
    }
  }
}

/// Sets matrix_ with zeros.
void BodySystem::make_pattern(const ContactProblem& p, const std::vector<int>& dofs) {
  const BodyPattern pattern(p, contacts_of_dofs(p), dofs);
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
  const int* const run_start = run_start_.data();
  const int* const run_end = run_end_.data();
  const double* const G = wrenches_.row(0);
  for (int c = 0; c < wrenches_.num_contacts(); ++c, blocks += D * D) {
    const int begin = wrenches_.begin(c), end = wrenches_.end(c);
    for (int j = begin; j < end; ++j) {
      Local<D> column = Local<D>::Zero();  // R (row j of G)ᵀ
      for (int a = 0; a < D; ++a) {
        for (int b = 0; b < D; ++b) column[a] += blocks[a * D + b] * G[j * D + b];
      }
      for (int r = run_start[c], i = begin; r < run_start[c + 1]; ++r) {
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
  g.resize(size());
  wrenches_.momentum(s, g);
}

}  // namespace bipot
