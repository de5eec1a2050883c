#include "core/problem/problem_part.h"

namespace bipot {
namespace {

/// The values in these places; empty stays empty.
Vector picked(const Vector& whole, std::span<const int> places) {
  return whole.size() == 0 ? Vector() : Vector(whole(places));
}

/// These columns, with the rows that have a number.
SparseMatrix cut_columns(const SparseMatrix& whole, std::span<const int> columns,
                         const std::vector<int>& number, std::size_t rows) {
  Eigen::Index entries = 0;
  for (const int j : columns) entries += whole.outerIndexPtr()[j + 1] - whole.outerIndexPtr()[j];
  SparseMatrix part(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns.size()));
  part.reserve(entries);
  for (Eigen::Index j = 0; j < part.cols(); ++j) {
    part.startVec(j);
    for (SparseMatrix::InnerIterator it(whole, columns[to_size(j)]); it; ++it) {
      const int row = number[to_size(it.row())];
      if (row >= 0) part.insertBack(row, j) = it.value();
    }
  }
  part.finalize();
  return part;
}

}  // namespace

std::vector<int> rows_of_contacts(std::span<const int> contacts, int whole_dim, int dim) {
  std::vector<int> rows;
  rows.reserve(contacts.size() * to_size(dim));
  for (const int c : contacts) {
    for (int k = 0; k < dim; ++k) rows.push_back(c * whole_dim + k);
  }
  return rows;
}

ContactProblem cut_problem(const ContactProblem& whole, std::span<const int> contacts, int dim,
                           std::span<const int> dofs, const std::vector<int>& number) {
  const std::vector<int> rows = rows_of_contacts(contacts, whole.dim, dim);
  ContactProblem p{.dim = dim};
  if (whole.has_velocities()) {
    p.A = cut_columns(whole.A, dofs, number, dofs.size());
    p.H = cut_columns(whole.H, rows, number, dofs.size());
    p.v_free = picked(whole.v_free, dofs);
  }
  p.u_free = picked(whole.u_free, rows);
  p.mu = picked(whole.mu, contacts);
  p.mu_r = picked(whole.mu_r, contacts);
  p.mu_spin = picked(whole.mu_spin, contacts);
  p.row_scale = picked(whole.row_scale, rows);
  return p;
}

}  // namespace bipot
