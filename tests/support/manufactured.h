#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// A problem with a known solution, at any size and contact dimension. A chain-like random network
/// of bodies (3 degrees of freedom each for d <= 2, 6 for d = 3) is joined by random contacts; an
/// impulse in the cone and a velocity that obeys the law are drawn contact by contact (a third each
/// of take-off, stick and slip), and u_free = u - W s.
struct Manufactured {
  ContactProblem problem;
  Vector s, u;  ///< a solution; s is unique only where W is regular, u where the solution is
};
Manufactured manufactured_problem(int dim, int bodies, int contacts, unsigned seed,
                                  double mu = 0.4);
/// The same with rolling friction, rows = 3 (plane) or 6 (space). Each part of a contact that pushes
/// is on its bound with one chance in two.
Manufactured manufactured_rolling(int rows, int bodies, int contacts, unsigned seed);

/// The same contacts and impulses, where random equality rows G v = b join the first three bodies,
/// as many as a body has degrees of freedom. v and λ are drawn; b, v_free and u_free follow.
struct ManufacturedJoints {
  ContactProblem problem;
  Vector s, u, v, multipliers;
};
ManufacturedJoints manufactured_joints(int dim, int bodies, int contacts, unsigned seed,
                                       double mu = 0.4);

}  // namespace bipot
