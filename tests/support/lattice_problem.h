#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// Equal disks (spheres for the cubic lattice) at rest, one time step under gravity. Values are in
/// units chosen by the caller: a change of units multiplies radius, mass and so on alike.
///
/// Written without the scenes, the detection and the assembly of core/ on purpose: an independent
/// check on them, and the only lattices with d = 3. Scenes of lattices: core/scene/scene_family.h.
struct LatticeOptions {
  int dim = 2;              ///< 1: no tangential rows, no rotations
  double mu = 0.3;          ///<                                                               [-]
  double tilt = 0;          ///< angle between gravity and the lattice's vertical            [rad]
  double turn = 0;          ///< rotation of the whole scene, gravity included               [rad]
  double radius = 1e-3;     ///<                                                               [m]
  double mass = 1e-2;       ///<                                                              [kg]
  double gravity = 9.81;    ///<                                                            [m/s²]
  double time_step = 1e-3;  ///<                                                             [s]
  double e_n = 0, e_t = 0;  ///< restitution; the disks are at rest, so it only scales W     [-]
};

/// n x n disks on a square lattice between two walls, on a floor.
ContactProblem square_lattice(int n, const LatticeOptions& options = {});

/// n rows of alternately n and n - 1 disks, the long rows held between two walls, on a floor.
ContactProblem triangular_lattice(int n, const LatticeOptions& options = {});

/// Free pyramid of n rows on a floor: n disks, n - 1, ..., 1. Friction alone holds it.
ContactProblem pyramid(int n, const LatticeOptions& options = {});

/// n³ spheres on a cubic lattice on a floor between four walls; dim is taken as 3.
ContactProblem cubic_lattice(int n, const LatticeOptions& options = {});

/// The fixed wall of a lattice with this normal becomes one of `mass` kg that forces drive along it,
/// as the last degree of freedom; `speed` is its free velocity [m/s].
ContactProblem with_driven_wall(const ContactProblem& lattice, const Vector& normal, double mass,
                                double speed);

}  // namespace bipot
