#pragma once

#include "core/problem/contact_problem.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/frontal_cholesky.h"
#include "solvers/kernels/body_pattern.h"

namespace bipot {

/// K = A + G R Gᵀ in all degrees of freedom, G = H diag(scale) and R block-diagonal, as of BodySystem,
/// for a factorisation that takes its columns one by one: K is nowhere stored, and G is read out of H.
class BodyColumns {
 public:
  /// Keeps references to both. The problem must have A and H. `scale`: m, of the columns of H.
  BodyColumns(const ContactProblem& problem, const Vector& scale);
  BodyColumns(ContactProblem&&, const Vector&) = delete;  // would dangle
  BodyColumns(const ContactProblem&, Vector&&) = delete;

  /// Of K, zeros included.
  BodyPattern pattern() const;
  /// Adds to `to` what it takes of column j, for the blocks of R, row-major, contact after contact.
  void add(int j, const double* blocks, const FrontColumn& to) const;

  /// g = G s: m -> n. No allocation where g has its size.
  void momentum(const Vector& s, Vector& g) const;
  /// The rows of Gᵀ v of one contact; D is the problem's.
  template <int D>
  Local<D> velocity(int contact, const Vector& v) const {
    Local<D> u;
    for (int a = 0; a < D; ++a) {
      double sum = 0;
      for (SparseMatrix::InnerIterator it(problem_.H, contact * D + a); it; ++it) {
        sum += it.value() * v[it.row()];
      }
      u[a] = scale_[contact * D + a] * sum;
    }
    return u;
  }

 private:
  template <int D>
  void add_contacts(int j, const double* blocks, const FrontColumn& to) const;

  const ContactProblem& problem_;
  const Vector& scale_;
  ContactsOfDofs contacts_;
};

}  // namespace bipot
