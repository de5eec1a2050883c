#pragma once

#include <span>
#include <vector>

#include "core/problem/contact_problem.h"
#include "solvers/systems/body_pattern.h"

namespace bipot {

/// W = S Hᵀ A⁻¹ H S with diagonal S and A, computed from H on demand: in dense packings this takes
/// a tenth of the memory of W. For d <= 2. Blocks (i, j) and (j, i) are each other's transposes to
/// the last bit. Refers to the problem and to the scale. Not thread-safe.
class BodyDelassus {
 public:
  /// True if the problem has H and a diagonal A, and d <= 2.
  static bool serves(const ContactProblem& problem);
  /// `scale`: m, the diagonal of S.
  BodyDelassus(const ContactProblem& problem, const Vector& scale);

  /// at[a][b] is the entry of row a of contact j and column b of contact i.
  struct Block {
    int contact;  ///< j
    double at[2][2];
  };
  /// The blocks of the columns of contact i, j ascending, including its own even if that is zero.
  const std::vector<Block>& blocks(int i) const;

  /// velocity = A⁻¹ G s, size n, for the impulses s_j = impulse(j), summed as Sum; G = H S.
  template <class Sum, class Impulse>
  void move_bodies(const Impulse& impulse, std::vector<Sum>& velocity) const;
  /// A row of Gᵀ velocity, which is W s after move_bodies().
  template <class Sum>
  Sum relative_velocity(int row, const std::vector<Sum>& velocity) const;

  int num_dofs() const { return problem_.num_dofs(); }
  double mass(int dof) const { return problem_.A.valuePtr()[dof]; }
  /// The contacts that act on a degree of freedom, ascending.
  std::span<const int> contacts_of(int dof) const {
    const int first = contacts_.start[to_size(dof)];
    return std::span(contacts_.contact)
        .subspan(to_size(first), to_size(contacts_.start[to_size(dof) + 1] - first));
  }
  /// Access to G = H S: add(row, value) for the entries of a column, and one entry.
  template <class Add>
  void for_column_of_G(int column, const Add& add) const {
    for (SparseMatrix::InnerIterator it(problem_.H, column); it; ++it) {
      add(static_cast<int>(it.row()), it.value() * scale_[column]);
    }
  }
  double entry_of_G(int row, int column) const {
    for (SparseMatrix::InnerIterator it(problem_.H, column); it; ++it) {
      if (it.row() == row) return it.value() * scale_[column];
    }
    return 0;
  }
  /// Pattern of A + G C Gᵀ, where C has one block for each contact.
  BodyPattern body_pattern() const;

 private:
  void find_neighbours(int i) const;
  double entry(int row, int column) const;

  const ContactProblem& problem_;
  const Vector& scale_;
  ContactsOfDofs contacts_;
  mutable std::vector<int> neighbours_;  // scratch
  mutable std::vector<Block> blocks_;    // of the contact that was asked for last
  mutable int last_ = -1;
};

template <class Sum, class Impulse>
void BodyDelassus::move_bodies(const Impulse& impulse, std::vector<Sum>& velocity) const {
  velocity.assign(to_size(problem_.num_dofs()), 0);
  for (int j = 0; j < problem_.num_rows(); ++j) {
    const Sum push = scale_[j] * impulse(j);
    if (push == 0) continue;
    for (SparseMatrix::InnerIterator it(problem_.H, j); it; ++it) {
      velocity[to_size(it.row())] += it.value() * push;
    }
  }
  for (std::size_t k = 0; k < velocity.size(); ++k) velocity[k] /= mass(static_cast<int>(k));
}

template <class Sum>
Sum BodyDelassus::relative_velocity(int row, const std::vector<Sum>& velocity) const {
  Sum sum = 0;
  for (SparseMatrix::InnerIterator it(problem_.H, row); it; ++it) {
    sum += it.value() * velocity[to_size(it.row())];
  }
  return scale_[row] * sum;
}

}  // namespace bipot
