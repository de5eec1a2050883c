#pragma once

#include <memory>
#include <string>

#include "core/base/types.h"

namespace bipot {

struct EqualityRows;  // core/problem/equality_rows.h

/// One step of the frictional contact problem: find s with
///
///     u = W s + u_free,      K_mu* ∋ u + mu |u_t| n  ⟂  s ∈ K_mu        (18), (19)
///
/// and W = Hᵀ A⁻¹ H the Delassus operator. Contact i owns the rows [i*dim, (i+1)*dim): normal
/// first, then tangents. u_n > 0 opens, s_n > 0 pushes apart. u is Moreau's mean velocity (36).
///
/// Two forms. *Global*: A and H are given; the velocities are v = v_free + A⁻¹ H s. *Local*: A and
/// H are empty and W alone is given. A global problem may leave W empty: solvers that need it say
/// so in the registry, the others work through H and A (see delassus.h).
///
/// With restitution the variables of this struct are the symmetric ones of
/// data/manual/explanation/method.md §3. With r = sqrt(1 + e) per row, they are s = r s_phys, u = r
/// u_phys, and H, W, u_free and mu are those of the scaled problem (H = H_phys diag(1/r), mu =
/// mu_phys r_t / r_n). `row_scale` holds r, so that the criterion can be evaluated in physical
/// variables; empty means all ones. [ours] The two variables scale alike, hence s·u = (1 + e)
/// s_phys·u_phys componentwise, and the right-hand side is u_free = diag(1/r) (Hᵀ v_free + E u⁻).
///
/// Equality rows are eliminated before: A, H and v_free are then those of the coordinates that the
/// rows leave.
///
/// Rolling friction: a contact then has more rows, velocities of rolling [rad/s] with moments [N m s]
/// as their impulses. In the plane d = 3: n, t, m. In space d = 6: n, t1, t2, m1, m2 about the
/// tangents, and m_spin about the normal. K = {|s_t| <= mu s_n, |m| <= mu_r s_n, |m_spin| <= mu_spin
/// s_n}, and û_n = u_n + mu |u_t| + mu_r |w| + mu_spin |w_spin|.
struct ContactProblem {
  int dim = 2;       ///< d, rows of a contact: 1 (frictionless), 2 or 3; rolling: 3 or 6    [-]
  SparseMatrix A;    ///< n x n, symmetric positive definite                      [kg | kg m²]
  SparseMatrix H;    ///< n x m, wrench map                                            [- | m]
  SparseRows W;      ///< m x m, Delassus operator, may be singular                     [1/kg]
  Vector v_free;     ///< n, velocities without contact impulses                 [m/s | rad/s]
  Vector u_free;     ///< m, value of u at s = 0                                         [m/s]
  Vector mu;         ///< one friction coefficient per contact                             [-]
  Vector mu_r;       ///< rolling friction, one per contact; empty: none                   [m]
  Vector mu_spin;    ///< the same about the normal, in space only                         [m]
  Vector row_scale;  ///< m or empty, r = sqrt(1 + e)                                      [-]
  /// The rows that were eliminated, and the problem as given; null: none.
  std::shared_ptr<const EqualityRows> equality;

  int num_contacts() const { return static_cast<int>(mu.size()); }
  int num_rows() const { return static_cast<int>(u_free.size()); }
  int num_dofs() const { return static_cast<int>(H.rows()); }
  bool rolls() const { return mu_r.size() > 0; }
  /// d without the rows of rolling.
  int plain_dim() const { return !rolls() ? dim : (dim == 6 ? 3 : 2); }
  bool has_velocities() const { return A.rows() > 0 && H.rows() > 0; }
  bool has_delassus() const { return W.rows() > 0; }
};

/// True if every stored off-diagonal entry of A is zero.
bool is_diagonal(const SparseMatrix& A);

/// Empty for a sound problem, otherwise one sentence that names the field, the index and the value
/// (or both sizes). Refused are wrong sizes, non-finite values, a non-positive diagonal of A, W_nn
/// <= 0, negative friction, and non-positive row_scale. Refused too are tangents of a contact with
/// different row_scale (rolling rows likewise), unsymmetric A, and W that is not compressed. W is taken as it is:
/// see delassus_defect().
std::string validate(const ContactProblem& problem);

/// The part of it that concerns the vectors: sizes, finite values, mu, row_scale.
std::string validate_vectors(const ContactProblem& problem);

/// Empty if W can be a Delassus operator Hᵀ A⁻¹ H, else one sentence that names the entries and
/// the size of the defect. W must be symmetric and positive semidefinite, and it must agree with A
/// and H where these are given too. Problems without W pass. The problem must pass validate().
///
/// Rounded data of other codes pass. With the diagonal scaled to 1, W and Wᵀ may differ by 1e-2 of
/// W in the Frobenius norm and by 0.1 in an entry. The smallest eigenvalue may be -1e-2 times the
/// largest sum of a row. Up to 300 rows a dense Cholesky factorisation of the shifted matrix
/// decides. Beyond, 60 products with W bound the smallest eigenvalue from above (Lanczos): what is
/// refused is indefinite, but a weak indefiniteness may pass. Readers of files and the Python
/// module call it; solve() does not, as it costs as much as tens of iterations.
std::string delassus_defect(const ContactProblem& problem);

}  // namespace bipot
