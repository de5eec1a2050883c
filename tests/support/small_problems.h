#pragma once

#include <string>

#include "core/problem/contact_problem.h"

namespace bipot {

/// One contact on one body of mass 1/w_n in the normal and 1/w_t in the tangential directions, with
/// A and H: u_n = w_n s_n + b_n, u_t = w_t s_t + b_t. The solution follows by hand:
///   take-off  b_n >= 0:                          s = 0
///   stick     |b_t| / w_t <= -mu b_n / w_n:      s_n = -b_n / w_n, s_t = -b_t / w_t, u = 0
///   slip      otherwise:                         s_n = -b_n / w_n, |s_t| = mu s_n against b_t
ContactProblem one_contact_problem(int dim, double w_n, double w_t, double mu, double b_n,
                                   const Vector& b_t);

/// Four bars of 1 kg and 1 m are pinned to a square, which stands on a corner and slides at 0.5
/// m/s, for a step of 1 ms. One contact; the pins are the equality rows G v = 0. By symmetry s_n
/// moves it by V and changes the angle of its bars by a', the friction mu s_n against the motion
/// slows it by U and turns it by w. Both rotations have the inertia 4 (1/12 + 1/4) = 4/3 kg m², and
/// the corner the lever r = 1/√2 m. So W is diagonal, 1/4 + r²/(4/3) = 5/8 twice, and s_n = 8/5 g h.
/// The bars at the corner turn by w ± a' = -(mu ± 1) s_n r/(4/3).
struct FourBars {
  ContactProblem problem;  ///< without the pins
  SparseRows G;            ///< 8 x 12, two rows a pin
  Vec2 s;                  ///< the answer [N s]
  double slides_at;        ///< u_t [m/s]
  Vec2 turns_at;           ///< spins of the first and the last bar [rad/s]
};
FourBars four_bars();

/// A problem given by W alone.
ContactProblem delassus_problem(int dim, const Eigen::MatrixXd& W, const Vector& b,
                                const Vector& mu);

/// A problem of bodies whose masses and moments of inertia are 1; u_free is Hᵀ v_free.
ContactProblem unit_masses(int dim, const Eigen::MatrixXd& H, const Vector& v_free,
                           const Vector& mu);

/// The same problem without A and H: W alone.
ContactProblem local_form(const ContactProblem& problem);

/// A lattice of lattice_problem.h with disks of 1 kg and radius 1/2 m, step 0.01 s, gravity tilted
/// by `tilt` degrees; mu = 0 gives d = 1.
enum class Lattice { kSquare, kTriangular, kPyramid };
ContactProblem lattice_step(Lattice lattice, int rows, double mu, double tilt);

/// A file of data/problems, by its name with ".hdf5".
ContactProblem shipped_file(const std::string& name);

/// The problem in other units: mass, length and time multiplied by these factors.
ContactProblem in_units(const ContactProblem& problem, double mass, double length, double time);

}  // namespace bipot
