#pragma once

#include <vector>

#include "core/problem/contact_problem.h"
#include "core/problem/contact_wrenches.h"

namespace bipot {

/// K = A + G R Gᵀ in the degrees of freedom of the bodies, with G = H diag(scale). R is
/// block-diagonal (one d x d block for each contact, in units of W⁻¹). Eliminating the contacts
/// from W + R⁻¹ gives K, in the units of A if scale is 1. The pattern is made once; values are
/// assembled in place.
class BodySystem {
 public:
  /// Degrees of freedom that contacts act on, ascending.
  static std::vector<int> touched(const ContactProblem& problem);

  /// In the degrees of freedom `dofs`, ascending; A must not couple them to others. `scale`: m, of
  /// the columns of H. The problem must have A and H.
  BodySystem(const ContactProblem& problem, const std::vector<int>& dofs, const Vector& scale);

  int size() const { return static_cast<int>(matrix_.cols()); }
  /// K for the blocks of R, row-major, contact after contact.
  const SparseMatrix& assemble(const double* blocks);
  const SparseMatrix& matrix() const { return matrix_; }
  /// g = G s: m -> size(). No allocation if g has its size.
  void momentum(const Vector& s, Vector& g) const;
  /// u = Gᵀ v: size() -> m.
  void velocity(const Vector& v, Vector& u) const { wrenches_.velocity(v, u); }

 private:
  void make_pattern(const ContactProblem& problem, const std::vector<int>& dofs);
  void list_runs();
  template <int D>
  void add_contacts(const double* blocks);

  int dim_;
  ContactWrenches wrenches_;  // degrees of freedom by their numbers among the unknowns
  SparseMatrix matrix_;
  std::vector<double> mass_;  // entries of A
  std::vector<int> mass_slot_;
  // A run is a set of consecutive unknowns of a contact, such as those of a body: in a column of
  // matrix_ their rows are consecutive. By contact: runs, and ends of runs among its entries.
  std::vector<int> run_start_, run_end_;
  std::vector<int> slot_;  // positions of the runs in each column of the contact's square block
};

}  // namespace bipot
