#pragma once

#include "solvers/solver.h"

namespace bipot {

/// An impulse that holds a packing at rest, in one pass: H s = -A v_free with s ∈ K_mu, so that
/// all velocities vanish and the law holds exactly.
///
/// Bodies are taken from the top of the load down. The direction of the load is the mean of
/// A v_free, a little aside if contacts lie across it. The order is that of Kahn (1962) on contacts
/// that lean along it. Each body has the impulses from above, and finds those of its contacts with
/// bodies below and with walls as if these stood still: by steep ones, then by all without
/// friction, then with it. This is the contact problem of one body, by Gauss-Seidel sweeps. [ours];
/// cf. shock propagation (Guendelman, Bridson and Fedkiw 2003): velocities frozen from below.
///
/// It solves ordered packings: lattices, walls of spheres. In piles, arches hold bodies from aside,
/// and in pyramids friction acts between rows: it gives up at the first such body, which the
/// message names, with status kStalled and s = 0. So does it for bodies that are not packed
/// (disk_structure.h, sphere_structure.h), and where velocities before the step enter u_free.
///
/// The force network is its own, one of many that hold the packing: not for pictures of forces.
void solve_load_path(SolveRun& run);

}  // namespace bipot
