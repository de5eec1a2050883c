#pragma once

#include <vector>

#include "core/motion/assembly.h"
#include "core/motion/state.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// A step before its contact problem: everything at the mid-point q_m = q + h/2 v (38).
struct Midpoint {
  std::vector<Disk> disks;          ///< positions at the mid-point, velocities before the step
  std::vector<Wall> walls;          ///< likewise
  std::vector<Contact> contacts;    ///< candidates at the mid-point, sorted by (i, j)
  std::vector<Vec2> disk_v_free;    ///< v + h g, without contact impulses                 [m/s]
  std::vector<double> wall_v_free;  ///< of driven walls: along their direction, else 0    [m/s]
};

Midpoint make_midpoint(const Scene& scene, const State& state, int threads = 1);

/// The step's contact problem, see core/motion/assembly.h.
AssembledStep assemble_step(const Scene& scene, const Midpoint& mid, bool explicit_delassus,
                            int threads = 1);

}  // namespace bipot
