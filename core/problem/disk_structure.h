#pragma once

#include <optional>

#include "core/base/large_pages.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// The wrench map of rigid disks (data/manual/explanation/method.md §1), recognised in H and A and
/// packed for kernels that stream over contacts. With unit normal n, t = e3 x n and the body
/// velocities (V, w = a ω),
///
///     u_n = normal (n·(V_i - V_j)),      u_t = tangential (t·(V_i - V_j) - w_i - w_j).
///
/// The two factors hold 1/sqrt(1 + e); the arms a are inside w. In one dimension there is no w.
///
/// A wall of mass M that forces drive along its normal is a body as well, with inverse_mass = 1/M
/// and inverse_inertia = -1/M. A tangential impulse then changes t·V and w by opposite amounts, so
/// that it moves nothing at the wall's contacts, which have one normal.
struct DiskStructure {
  struct Contact {
    int i = 0, j = 0;  ///< bodies; a fixed partner is `surroundings`
    double n[2] = {0, 0};
    double normal = 1, tangential = 1;
  };
  struct Body {
    double inverse_mass = 0;
    double inverse_inertia = 0;  ///< a² / I, which multiplies tangential impulses  [1/kg]
    double arm = 0;              ///< a, of its contacts; 0 in one dimension  [m]
  };
  LargeVector<Contact> contacts;
  /// The disks, the driven walls, and a last one for the surroundings: it never moves.
  LargeVector<Body> bodies;
  int walls = 0;  ///< driven ones

  int surroundings() const { return static_cast<int>(bodies.size()) - 1; }
  int first_wall() const { return surroundings() - walls; }
};

/// The structure of the problem's (A, H); empty if they do not have it to rounding. A must be
/// diagonal with equal masses in x and y. Body k must own the degrees of freedom (2k, 2k+1) for dim
/// 1, and (3k, 3k+1, 3k+2) for dim 2; driven walls follow, with one degree of freedom each. Every
/// contact must obey the formulas above with one arm for each body. Refused are other bodies, walls
/// driven across their normal or touched from both sides, dim = 3, and rolling friction.
std::optional<DiskStructure> disk_structure(const ContactProblem& problem);

}  // namespace bipot
