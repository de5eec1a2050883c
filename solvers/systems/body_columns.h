#pragma once

#include "core/linear/frontal_cholesky.h"
#include "core/problem/contact_problem.h"
#include "core/problem/contact_wrenches.h"
#include "core/problem/coulomb_cone.h"
#include "solvers/systems/body_pattern.h"

namespace bipot {

/// K = A + G R Gᵀ in all degrees of freedom, for a factorisation that asks for its columns one by
/// one. G = H diag(scale), and R is block-diagonal as for BodySystem. K is not stored.
class BodyColumns {
 public:
  /// Keeps a reference to the problem, which must have A and H. `scale`: m, of the columns of H.
  BodyColumns(const ContactProblem& problem, const Vector& scale);
  BodyColumns(ContactProblem&&, const Vector&) = delete;  // would dangle

  /// Pattern of K, zeros included.
  BodyPattern pattern() const;
  /// Diagonal of A, of the order of K's.
  Vector diagonal() const { return problem_.A.diagonal(); }
  /// Adds the entries of column j that `to` takes, for the blocks of R, row-major, contact after
  /// contact.
  void add(int j, const double* blocks, const FrontalCholesky::Column& to) const;

  /// g = G s - A v. No allocation if g has its size.
  void residual(const Vector& s, const Vector& v, Vector& g) const;
  /// The rows of Gᵀ v of one contact; D is the problem's.
  template <int D>
  Local<D> velocity(int contact, const Vector& v) const {
    return wrenches_.velocity<D>(contact, v);
  }

 private:
  template <int D>
  void add_contacts(int j, const double* blocks, const FrontalCholesky::Column& to) const;

  const ContactProblem& problem_;
  ContactWrenches wrenches_;
  Lists<> contacts_;  // of each degree of freedom
};

}  // namespace bipot
