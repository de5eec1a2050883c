#pragma once

#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// Bodies through an outlet or an inlet: since step 0, and in the last change.
template <int D>
struct GateFlow {
  int count = 0;                     ///< bodies
  double mass = 0;                   ///< [kg]
  double energy = 0;                 ///< kinetic, and potential at the time                  [J]
  Vec<D> momentum = Vec<D>::Zero();  ///< [kg m/s]
  int waiting = 0;       ///< inlets: number of steps without room for bodies that were due
  double last_mass = 0;  ///< in the last step                                    [kg]
};

/// The bodies present, in scenes with outlets or inlets; empty in all others.
template <int D>
struct Population {
  /// Numbers of the bodies, increasing: those of the scene keep theirs, new ones get the next.
  std::vector<int> numbers;
  std::vector<GateFlow<D>> outlets, inlets;  ///< as many as the scene has
};

/// The changing part of a scene: all data for a restart.
template <int D>
struct State {
  double time = 0;  ///< [s]
  int step = 0;     ///< steps done
  std::vector<Body<D>> bodies;
  Clusters<D> clusters;  ///< bodies that are joined rigidly
  std::vector<Wall<D>> walls;
  PeriodicCell cell;                        ///< of periodic scenes
  Population<D> population;                 ///< of scenes with outlets or inlets
  std::vector<ContactOutcome<D>> contacts;  ///< of the last step, sorted by (i, j); warm start
  /// Accumulated since step 0, for the ledger                                  [J]
  double wall_work = 0, friction_loss = 0, shock_loss = 0, cohesion_loss = 0;
  /// The next step begins with 2^halvings parts, because earlier ones were not solved with fewer.
  int halvings = 0;
};

template <int D>
State<D> initial_state(const Scene<D>& scene);

/// The time after one more step of size h. It is a multiple of h, which has no drift, unless the
/// step size changed at a restart.
template <int D>
double time_after_step(const State<D>& state, double h) {
  const bool multiple = std::abs(state.time - state.step * h) <= 1e-6 * h;
  return multiple ? (state.step + 1) * h : state.time + h;
}

/// Where a body was in the middle of the step of size h that it has just taken.
template <int D>
Vec<D> middle_of_step(const Body<D>& body, double h) {
  return body.x - 0.5 * h * body.v;
}

/// Sums over the bodies of a state, computed in one pass.
template <int D>
struct StateSums {
  double kinetic = 0;                ///< disks, driven walls and sides of a cell  [J]
  double potential = 0;              ///< zero at the origin                       [J]
  Vec<D> momentum = Vec<D>::Zero();  ///< disks and driven walls                   [kg m/s]
};
/// `count_walls`: false where another process counts the walls.
template <int D>
StateSums<D> state_sums(const State<D>& state, const std::type_identity_t<Vec<D>>& gravity,
                        bool count_walls = true);
/// Single sums; each call is a pass of its own.
template <int D>
double kinetic_energy(const State<D>& state) {
  return state_sums(state, Vec<D>::Zero()).kinetic;
}
template <int D>
double potential_energy(const State<D>& state, const std::type_identity_t<Vec<D>>& gravity) {
  return state_sums(state, gravity).potential;
}
template <int D>
Vec<D> momentum(const State<D>& state) {
  return state_sums(state, Vec<D>::Zero()).momentum;
}
/// Angular momentum of the disks about the origin, their spins included. [N m s]
template <int D>
Spin<D> angular_momentum(const State<D>& state);

/// Empty if a state has as many bodies, walls, clusters and gates as a scene, and no index beyond
/// its own, else one sentence.
template <int D>
std::string count_mismatch(const Scene<D>& scene, const State<D>& state);

/// Empty if a state can continue under a scene, else one sentence that names the difference. Disks
/// that have not left must be the same (radius, mass, inertia, material). So must outlets, inlets
/// and walls (shape, motion, force, mass, direction, material).
template <int D>
std::string restart_mismatch(const Scene<D>& scene, const State<D>& state);

}  // namespace bipot
