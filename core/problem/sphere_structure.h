#pragma once

#include <optional>

#include "core/problem/disk_structure.h"

namespace bipot {

/// The wrench map of rigid spheres, recognised in H and A and packed for kernels that stream over
/// contacts. With the frame n, t1, t2 of a contact and the body velocities (V, w = a ω),
///
///     u_n = normal (n·(V_i - V_j)),
///     u_k = tangential (t_k·(V_i - V_j) - (n x t_k)·(w_i + w_j)),  k = 1, 2.
///
/// The two factors hold 1/sqrt(1 + e); the arms a are inside w. Driven walls are bodies as in
/// DiskStructure.
struct SphereStructure {
  struct Contact {
    int i = 0, j = 0;         ///< bodies; a fixed partner is `surroundings`
    double frame[3][3] = {};  ///< n, t1, t2: orthonormal, of either hand
    double normal = 1, tangential = 1;
  };
  using Body = DiskStructure::Body;
  LargeVector<Contact> contacts;
  /// The spheres, the driven walls, and a last one for the surroundings: it never moves.
  LargeVector<Body> bodies;
  int walls = 0;  ///< driven ones

  int surroundings() const { return static_cast<int>(bodies.size()) - 1; }
};

/// The structure of the problem's (A, H); empty if they do not have it to rounding. The problem
/// must have dim = 3 and a diagonal A with one mass and one moment of inertia for each body. Body k
/// must own the degrees of freedom from 6k on: three translations, three rotations; driven walls
/// follow, with one degree of freedom each. Every contact must obey the formulas above with one arm
/// for each body. Refused are clusters, walls driven across their normal or touched from both
/// sides, and rolling friction.
std::optional<SphereStructure> sphere_structure(const ContactProblem& problem);

}  // namespace bipot
