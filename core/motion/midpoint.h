#pragma once

#include <vector>

#include "core/motion/assembly.h"
#include "core/motion/state.h"
#include "core/scene/contact.h"
#include "core/scene/contact_detection.h"
#include "core/scene/scene.h"

namespace bipot {

/// A step before its contact problem: everything at the midpoint q_m = q + h/2 v (38).
template <int D>
struct Midpoint {
  std::vector<Body<D>> bodies;         ///< positions at the mid-point, velocities before the step
  Clusters<D> clusters;                ///< likewise
  std::vector<Vec<D>> cluster_v_free;  ///< of their centres of mass, without contacts        [m/s]
  std::vector<Wall<D>> walls;          ///< likewise, as they are at that time (wall_motion.h)
  PeriodicCell cell;                   ///< likewise
  double side_v_free[3] = {0, 0, 0};   ///< of a cell's driven sides, without contacts        [m/s]
  std::vector<Contact<D>> contacts;    ///< candidates at the mid-point, sorted by (i, j)
  std::vector<Vec<D>> disk_v_free;     ///< v + h g, without contact impulses                 [m/s]
  std::vector<double> wall_v_free;     ///< of driven walls: along their direction, else 0    [m/s]
  std::vector<double> cohesion;        ///< of each contact; empty in scenes without        [N]
  Vec<D> gravity = Vec<D>::Zero();     ///< of the step: that of its middle                  [m/s²]
};

/// Sets bodies, walls and clusters again, for a midpoint whose `bodies` were released.
template <int D>
void place_bodies(const Scene<D>& scene, const State<D>& state, Midpoint<D>& mid, int threads = 1);

/// The same without contacts: positions, velocities and forces alone.
template <int D>
Midpoint<D> free_midpoint(const Scene<D>& scene, const State<D>& state, int threads = 1);

/// `kept`: neighbour lists of earlier steps, which change no bit.
template <int D>
Midpoint<D> make_midpoint(const Scene<D>& scene, const State<D>& state, int threads = 1,
                          KeptContacts<D>* kept = nullptr);

/// The step's contact problem, see core/motion/assembly.h.
template <int D>
AssembledStep assemble_step(const Scene<D>& scene, const Midpoint<D>& mid, int threads = 1);

/// Velocities after the step, then positions: q <- q_m + h/2 v⁺ (43). `v`: velocities after the
/// step in the degrees of freedom of the problem; bodies without any continue without contact
/// impulses. Sets disks, clusters, walls and cell of the state; moves the disks out of `mid`.
template <int D>
State<D> update_bodies(Midpoint<D>& mid, const DofMap& dofs, const Vector& v, double h);

}  // namespace bipot
