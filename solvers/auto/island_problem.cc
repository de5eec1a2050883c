#include "solvers/auto/island_problem.h"

#include <algorithm>
#include <utility>

namespace bipot {

Vector IslandProblem::gather(const Vector& whole) const {
  if (whole.size() == 0) return {};
  Vector part(static_cast<Eigen::Index>(rows.size()));
  for (std::size_t k = 0; k < rows.size(); ++k) part[static_cast<Eigen::Index>(k)] = whole[rows[k]];
  return part;
}

void IslandProblem::scatter(const Vector& part, int whole_dim, Vector& whole) const {
  for (int k = 0; k < problem.num_rows(); ++k) {
    whole[rows[to_size(k)]] = part[k];
    if (problem.dim < whole_dim) whole.segment(rows[to_size(k)] + 1, whole_dim - 1).setZero();
  }
}

IslandCutter::IslandCutter(const ContactProblem& whole)
    : whole_(whole),
      diagonal_(is_diagonal(whole.A)),
      dof_(to_size(whole.num_dofs()), -1),
      contact_(to_size(whole.num_contacts()), -1) {}

IslandProblem IslandCutter::operator()(std::span<const int> contacts) {
  IslandProblem island;
  ContactProblem& p = island.problem;
  const bool frictionless =
      !whole_.rolls() &&
      std::all_of(contacts.begin(), contacts.end(), [&](int c) { return whole_.mu[c] == 0; });
  p.dim = frictionless ? 1 : whole_.dim;
  p.mu.resize(static_cast<Eigen::Index>(contacts.size()));
  for (auto [part, all] :
       {std::pair{&p.mu_r, &whole_.mu_r}, std::pair{&p.mu_spin, &whole_.mu_spin}}) {
    if (all->size() > 0) part->resize(p.mu.size());
  }
  island.rows.reserve(contacts.size() * to_size(p.dim));
  Eigen::Index number = 0;
  for (const int c : contacts) {
    if (p.rolls()) p.mu_r[number] = whole_.mu_r[c];
    if (p.mu_spin.size() > 0) p.mu_spin[number] = whole_.mu_spin[c];
    p.mu[number++] = whole_.mu[c];
    for (int k = 0; k < p.dim; ++k) island.rows.push_back(c * whole_.dim + k);
  }
  p.u_free = island.gather(whole_.u_free);
  p.row_scale = island.gather(whole_.row_scale);
  if (whole_.has_velocities()) cut_bodies(island);
  if (whole_.has_delassus()) cut_delassus(contacts, island);
  return island;
}

/// If A couples them, the degrees of freedom beside the contacts' own take part.
void IslandCutter::add_coupled_dofs(std::vector<int>& dofs) {
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    for (SparseMatrix::InnerIterator it(whole_.A, dofs[k]); it; ++it) {
      int& number = dof_[to_size(it.row())];
      if (number >= 0 || it.value() == 0) continue;
      number = 0;
      dofs.push_back(static_cast<int>(it.row()));
    }
  }
}

void IslandCutter::cut_bodies(IslandProblem& island) {
  ContactProblem& p = island.problem;
  std::vector<int> dofs;
  Eigen::Index entries = 0;
  for (const int row : island.rows) {
    for (SparseMatrix::InnerIterator it(whole_.H, row); it; ++it, ++entries) {
      int& number = dof_[to_size(it.row())];
      if (number >= 0) continue;
      number = 0;
      dofs.push_back(static_cast<int>(it.row()));
    }
  }
  if (!diagonal_) add_coupled_dofs(dofs);
  std::sort(dofs.begin(), dofs.end());
  const int n = static_cast<int>(dofs.size());
  p.v_free.resize(n);
  for (int k = 0; k < n; ++k) {
    dof_[to_size(dofs[to_size(k)])] = k;
    p.v_free[k] = whole_.v_free[dofs[to_size(k)]];
  }
  p.H.resize(n, static_cast<Eigen::Index>(island.rows.size()));
  p.H.reserve(entries);
  for (std::size_t column = 0; column < island.rows.size(); ++column) {
    p.H.startVec(static_cast<Eigen::Index>(column));
    for (SparseMatrix::InnerIterator it(whole_.H, island.rows[column]); it; ++it) {
      p.H.insertBack(dof_[to_size(it.row())], static_cast<Eigen::Index>(column)) = it.value();
    }
  }
  p.H.finalize();
  p.A.resize(n, n);
  p.A.reserve(n);
  for (int k = 0; k < n; ++k) {
    p.A.startVec(k);
    for (SparseMatrix::InnerIterator it(whole_.A, dofs[to_size(k)]); it; ++it) {
      const int number = dof_[to_size(it.row())];
      // Zeros stored beside a diagonal may point out of the island.
      if (number >= 0) p.A.insertBack(number, k) = it.value();
    }
  }
  p.A.finalize();
  for (const int dof : dofs) dof_[to_size(dof)] = -1;
}

void IslandCutter::cut_delassus(std::span<const int> contacts, IslandProblem& island) {
  ContactProblem& p = island.problem;
  const int m = static_cast<int>(island.rows.size());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    contact_[to_size(contacts[k])] = static_cast<int>(k);
  }
  p.W.resize(m, m);
  Eigen::Index entries = 0;
  for (const int row : island.rows) {
    entries += whole_.W.outerIndexPtr()[row + 1] - whole_.W.outerIndexPtr()[row];
  }
  p.W.reserve(entries);
  for (int i = 0; i < m; ++i) {
    p.W.startVec(i);
    for (SparseRows::InnerIterator it(whole_.W, island.rows[to_size(i)]); it; ++it) {
      const int column = static_cast<int>(it.col());
      const int number = contact_[to_size(column / whole_.dim)];
      if (number < 0 || column % whole_.dim >= p.dim) continue;
      p.W.insertBack(i, number * p.dim + column % whole_.dim) = it.value();
    }
  }
  p.W.finalize();
  for (const int c : contacts) contact_[to_size(c)] = -1;
}

}  // namespace bipot
