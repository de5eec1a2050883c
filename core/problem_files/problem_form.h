#pragma once

#include "core/base/triplets.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// A matrix as a file holds it, independent of its storage.
struct StoredEntries {
  int rows = 0, columns = 0;
  Triplets entries;

  template <class Sparse>
  Sparse build() const {
    return from_triplets<Sparse>(rows, columns, entries);
  }
};

/// The local form W r + q of other codes, with rolling friction if mu_r is not empty. Explicit zeros
/// are dropped. W remains as it is, even if rounding has made it unsymmetric. Throws std::invalid_argument for an unsound problem.
ContactProblem from_local_form(int dim, const SparseRows& W, Vector q, Vector mu, Vector mu_r = {},
                               Vector mu_spin = {});

/// The local form with equality rows, u = W r + V λ + q, 0 = Vᵀ r + R λ + s, from which λ is
/// eliminated: W - V R⁻¹ Vᵀ and q - V R⁻¹ s. R may be singular where rows depend on each other
/// (pivots below 1e-8 of a unit diagonal). Throws std::invalid_argument likewise, and for rows that
/// contradict others, and for more than 5000 of them or of rows of contacts that they touch: these
/// are dense.
ContactProblem from_local_form(int dim, const SparseRows& W, const Vector& q, Vector mu,
                               const SparseRows& V, const SparseMatrix& R, const Vector& s);

/// v = M⁻¹ f. Throws std::invalid_argument if M is not positive definite.
Vector velocity_of(const SparseMatrix& M, const Vector& f);

/// The global form M v = H r + f, u = Hᵀ v + w. Hence A = M, v_free = M⁻¹ f, u_free = Hᵀ v_free +
/// w. For a diagonal M, W stays empty (two passes through H are cheaper); else it is assembled.
/// Throws std::invalid_argument for an unsound problem.
ContactProblem from_global_form(int dim, const SparseMatrix& M, const SparseMatrix& H,
                                const Vector& f, const Vector& w, Vector mu, Vector mu_r = {},
                                Vector mu_spin = {});

}  // namespace bipot
