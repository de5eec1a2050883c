#pragma once

#include "solvers/solver.h"

namespace bipot {

/// Practical limit of one dense inverse of 4 rows for each contact.
inline constexpr int kLemkeMaxContacts = 300;

/// Exact reference for tiny problems, d <= 2: Coulomb's law as a linear complementarity problem
/// with a copositive matrix (Stewart and Trinkle 1996) and Lemke's pivoting on it. For each contact
/// the unknowns are s_n, the two parts b+, b- >= 0 of s_t = b+ - b-, and the sliding speed l:
///
///     0 <= u_n              ⟂  s_n >= 0
///     0 <= l + u_t          ⟂  b+  >= 0
///     0 <= l - u_t          ⟂  b-  >= 0
///     0 <= mu s_n - b+ - b-  ⟂  l   >= 0
///
/// (d = 1: the first line alone. Rolling friction in the plane: the last three lines once more, for
/// moments.) W may be singular. Ties in the ratio test are broken
/// lexicographically, so that pivoting cannot cycle. The basis inverse is dense and rebuilt from
/// the data at intervals. The final basis is solved again with refinement. The start s0 is not
/// used: pivoting begins at s = 0. An iteration is one pivot.
///
/// Deviations: variables are equilibrated, and a normal impulse counts max(1, mu) times, as the
/// tangential ones are that large. The covering vector is drawn (fixed seed): with a vector of
/// ones, symmetric scenes have ties at most vertices, and rounding can cause cycles. Pivoting may
/// end on a ray: in exact arithmetic only for problems without the copositivity property, e.g.
/// without a solution, in floating point also by rounding. Then up to four more vectors are tried,
/// and the message says so.
void solve_lemke(SolveRun& run);

}  // namespace bipot
