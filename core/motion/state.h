#pragma once

#include <string>
#include <vector>

#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// The moving part of a scene: all that a restart needs.
struct State {
  double time = 0;  ///< [s]
  int step = 0;     ///< steps done
  std::vector<Disk> disks;
  std::vector<Wall> walls;
  std::vector<ContactOutcome> contacts;  ///< of the last step, sorted by (i, j); warm start
  /// Accumulated since step 0, for the ledger                                  [J]
  double wall_work = 0, friction_loss = 0, shock_loss = 0;
};
State initial_state(const Scene& scene);

/// The time after one more step of size h: a multiple of h, which has no drift, unless the step
/// size was another one before a restart.
double time_after_step(const State& state, double h);

double kinetic_energy(const State& state);                         ///< disks and driven walls [J]
double potential_energy(const State& state, const Vec2& gravity);  ///< zero at the origin     [J]
Vec2 momentum(const State& state);  ///< disks and driven walls [kg m/s]

/// Empty when a state can go on under a scene: same disks (radius, mass, inertia, material) and
/// walls (shape, motion, force, mass, direction, material); else one sentence that names the
/// difference.
std::string restart_mismatch(const Scene& scene, const State& state);

}  // namespace bipot
