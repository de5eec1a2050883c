#pragma once

#include <algorithm>
#include <vector>

#include "core/problem/contact_problem.h"
#include "solvers/kernels/body_pattern.h"

namespace bipot {

/// W = S Hᵀ A⁻¹ H S with diagonal S and A, read out of H whenever it is asked for: in dense packings a
/// tenth of the memory of W. For d <= 2. Blocks (i, j) and (j, i) are each other's transposes to the
/// last bit. Refers to the problem and to the scale. Not for several threads at once.
class BodyDelassus {
 public:
  /// Whether the problem has H and a diagonal A, and d <= 2.
  static bool serves(const ContactProblem& problem);
  /// `scale`: m, the diagonal of S.
  BodyDelassus(const ContactProblem& problem, const Vector& scale);

  /// at[a][b] is the entry of row a of contact j and column b of contact i.
  struct Block {
    int contact;  ///< j
    double at[2][2];
  };
  /// The blocks of the columns of contact i, j ascending, its own among them even where it is zero.
  const std::vector<Block>& blocks(int i) const;

  /// out += W s, both m, summed as Sum; `momentum`: scratch.
  template <class Sum>
  void add_product(const Sum* s, Sum* out, std::vector<Sum>& momentum) const;

  /// Of whole blocks.
  struct Pattern {
    MappedVector<int> start, row;
    operator SymmetricPattern() const {  // NOLINT(google-explicit-constructor)
      return {static_cast<int>(start.size()) - 1, start.data(), row.data()};
    }
  };
  Pattern pattern() const;

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

template <class Sum>
void BodyDelassus::add_product(const Sum* s, Sum* out, std::vector<Sum>& momentum) const {
  const SparseMatrix& H = problem_.H;
  momentum.assign(to_size(problem_.num_dofs()), 0);
  for (int j = 0; j < problem_.num_rows(); ++j) {
    const Sum push = scale_[j] * s[j];
    if (push == 0) continue;
    for (SparseMatrix::InnerIterator it(H, j); it; ++it) {
      momentum[to_size(it.row())] += it.value() * push;
    }
  }
  const double* const mass = problem_.A.valuePtr();
  for (std::size_t k = 0; k < momentum.size(); ++k) momentum[k] /= mass[k];
  for (int j = 0; j < problem_.num_rows(); ++j) {
    Sum velocity = 0;
    for (SparseMatrix::InnerIterator it(H, j); it; ++it) {
      velocity += it.value() * momentum[to_size(it.row())];
    }
    out[j] += scale_[j] * velocity;
  }
}

}  // namespace bipot
