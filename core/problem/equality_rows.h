#pragma once

#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Equality rows of a problem (bilateral joints): with multipliers λ, impulses of the joints,
///
///     A v = A v_free + H s + Gᵀ λ,      G v = b.
///
/// They are eliminated exactly, before any solver. Degrees of freedom that A and G couple make a
/// part. In a part all velocities that obey its rows are v = v_p + Z y, with G Z = 0, Zᵀ A Z = 1
/// and v_p the smallest in the norm of A. So y has the mass matrix 1, the wrench map Zᵀ H and the
/// free velocity Zᵀ A v_free. The result is a problem of the ordinary form in y and the other
/// degrees of freedom, which keep their own mass and columns. [ours]
struct EqualityRows {
  /// Degrees of freedom that rows couple.
  struct Part {
    std::vector<int> dofs, rows;      ///< of the given problem, and of G
    int first = 0;                    ///< coordinate of the problem where its y begins
    Eigen::MatrixXd basis;            ///< Z
    Vector particular;                ///< v_p
    Eigen::MatrixXd multipliers_map;  ///< λ = this (A (v - v_free) - H s)
  };
  ContactProblem given;   ///< the bodies and contacts without the rows
  SparseRows G;           ///< p x n, n of `given`                      [- | m]
  Vector b;               ///< p                                        [m/s]
  std::vector<int> free;  ///< dofs that no row couples: the first coordinates
  std::vector<Part> parts;
  std::vector<int> blocked;  ///< contacts without motion along their normal, of lenient rows
  bool lenient = false;

  /// Velocities v of the given problem from the coordinates of the reduced one.
  Vector velocities(const Vector& y) const;
};

/// The problem of `given` under the rows G v = b (see EqualityRows), which it keeps in `equality`.
/// Rows that depend on others are found by QR with column pivoting, after each was scaled to a unit
/// norm: pivots below 1e-9. λ is then the smallest one. A W of `given` is dropped.
///
/// Throws std::invalid_argument, with the row or the contact and its values: for a problem without
/// bodies, wrong sizes, rows that contradict others (beyond 1e-6 of the largest b), contacts along
/// whose normal the rows leave no motion, and parts of more than 5000 degrees of freedom, as they
/// are dense. `lenient`: of rows that contradict each other the nearest velocities are taken, and
/// contacts without motion have no effect.
ContactProblem with_equality_rows(ContactProblem given, SparseRows G, Vector b,
                                  bool lenient = false);

/// The problem as given without its equality rows; itself if it has none.
const ContactProblem& without_equality_rows(const ContactProblem& problem);

/// λ at the impulse s, one for each row [N s]; empty without rows.
Vector multipliers(const ContactProblem& problem, const Eigen::Ref<const Vector>& s);

/// max |G v - b| at the impulse s [m/s]; 0 without rows.
double equality_residual(const ContactProblem& problem, const Eigen::Ref<const Vector>& s);

}  // namespace bipot
