#include "solvers/auto/island_problem.h"

#include <algorithm>

#include "core/problem/problem_part.h"

namespace bipot {

Vector IslandProblem::gather(const Vector& whole) const {
  return whole.size() == 0 ? Vector() : Vector(whole(rows));
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
  const bool frictionless =
      !whole_.rolls() &&
      std::all_of(contacts.begin(), contacts.end(), [&](int c) { return whole_.mu[c] == 0; });
  const int dim = frictionless ? 1 : whole_.dim;
  IslandProblem island{.rows = rows_of_contacts(contacts, whole_.dim, dim)};
  std::vector<int> dofs;
  if (whole_.has_velocities()) dofs = number_dofs(island.rows);
  island.problem = cut_problem(whole_, contacts, dim, dofs, dof_);
  for (const int dof : dofs) dof_[to_size(dof)] = -1;
  if (whole_.has_delassus()) cut_delassus(contacts, island);
  return island;
}

/// The degrees of freedom of these rows, and those that A couples with them; sets their numbers.
std::vector<int> IslandCutter::number_dofs(const std::vector<int>& rows) {
  std::vector<int> dofs;
  const auto add = [&](Eigen::Index dof) {
    if (dof_[to_size(dof)] >= 0) return;
    dof_[to_size(dof)] = 0;
    dofs.push_back(static_cast<int>(dof));
  };
  for (const int row : rows) {
    for (SparseMatrix::InnerIterator it(whole_.H, row); it; ++it) add(it.row());
  }
  for (std::size_t k = 0; !diagonal_ && k < dofs.size(); ++k) {
    for (SparseMatrix::InnerIterator it(whole_.A, dofs[k]); it; ++it) {
      if (it.value() != 0) add(it.row());
    }
  }
  std::sort(dofs.begin(), dofs.end());
  for (std::size_t k = 0; k < dofs.size(); ++k) dof_[to_size(dofs[k])] = static_cast<int>(k);
  return dofs;
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
