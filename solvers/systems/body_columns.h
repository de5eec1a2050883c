#pragma once

#include "core/linear/frontal_cholesky.h"
#include "core/problem/contact_problem.h"
#include "core/problem/coulomb_cone.h"
#include "solvers/systems/body_pattern.h"

namespace bipot {

/// K = A + G R Gᵀ in all degrees of freedom, for a factorisation that asks for its columns one by
/// one. G = H diag(scale), and R is block-diagonal as for BodySystem. K is not stored; G is read
/// from H.
class BodyColumns {
 public:
  /// Keeps references to both. The problem must have A and H. `scale`: m, of the columns of H.
  BodyColumns(const ContactProblem& problem, const Vector& scale);
  BodyColumns(ContactProblem&&, const Vector&) = delete;  // would dangle
  BodyColumns(const ContactProblem&, Vector&&) = delete;

  /// Pattern of K, zeros included.
  BodyPattern pattern() const;
  /// Adds the entries of column j that `to` takes, for the blocks of R, row-major, contact after
  /// contact.
  void add(int j, const double* blocks, const FrontalCholesky::Column& to) const;

  /// g = G s: m -> n. No allocation if g has its size.
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
  void add_contacts(int j, const double* blocks, const FrontalCholesky::Column& to) const;

  const ContactProblem& problem_;
  const Vector& scale_;
  ContactsOfDofs contacts_;
};

}  // namespace bipot
