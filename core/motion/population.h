#pragma once

#include "core/motion/state.h"
#include "core/scene/scene.h"

namespace bipot {

/// The population of a scene before its first step; empty without outlets and inlets.
template <int D>
Population<D> initial_population(const Scene<D>& scene);

/// Changes a state between two steps: bodies whose centre lies in an outlet leave, and bodies that
/// are due in inlets come in if there is room (core/scene/gates.h). The others keep their order;
/// new ones come last. Contacts of the last step, from which the next one may start, are
/// renumbered. Those of bodies that left are dropped. Bodies glued to a wall stay. A cluster leaves
/// as a whole, by its centre of mass, and counts as one body. The energy and momentum that bodies
/// take along or bring are recorded in the population. A state thus shows the bodies of its own
/// step: a body that leaves is missing from the next step on.
///
/// Depends on the scene and the state alone. Returns true if bodies came or went. Throws
/// std::invalid_argument if the population of the state is not one of the scene.
template <int D>
bool change_population(const Scene<D>& scene, State<D>& state);

/// The state from which the next step starts.
template <int D>
State<D> with_changed_population(const Scene<D>& scene, const State<D>& state) {
  State<D> changed = state;
  if (scene.has_gates()) change_population(scene, changed);
  return changed;
}

/// Permanent number of a body, while others come and go; its index in scenes without gates.
template <int D>
int body_number(const State<D>& state, int index) {
  const std::vector<int>& numbers = state.population.numbers;
  return numbers.empty() ? index : numbers.at(to_size(index));
}
/// The index of the body with that number; -1 if it is not there.
template <int D>
int body_index(const State<D>& state, int number);

/// Energy and momentum that have come in, less those that have left, since step 0.
template <int D>
GateFlow<D> passed(const State<D>& state);

}  // namespace bipot
