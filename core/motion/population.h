#pragma once

#include "core/motion/state.h"
#include "core/scene/scene.h"

namespace bipot {

/// The population of a scene before its first step; empty without outlets and inlets.
template <int D>
Population<D> initial_population(const Scene<D>& scene);

/// What happens to a state in between two steps: bodies whose centre lies in an outlet leave, and those that
/// are due in inlets come in where there is room (core/scene/gates.h). The others keep their order, what comes
/// in stands last; the contacts of the last step, which the next one may start from, are renumbered, and those
/// of bodies that left are dropped. A state so shows the bodies that were there in its step: who leaves is gone
/// from the next one on. Bodies that are glued to a wall stay; a cluster leaves as a whole, by its centre of mass, and counts as one body. What they take along and bring is booked in
/// the population.
///
/// Depends on nothing but the scene and the state. Returns whether bodies came or went. Throws
/// std::invalid_argument for a state whose population is not one of the scene.
template <int D>
bool change_population(const Scene<D>& scene, State<D>& state);

/// The state that the next step starts from.
template <int D>
State<D> with_changed_population(const Scene<D>& scene, const State<D>& state);

/// The number of a body, which it keeps while others come and go: its index where none do.
template <int D>
int body_number(const State<D>& state, int index);
/// The index of the body of that number; -1 where it is not there.
template <int D>
int body_index(const State<D>& state, int number);

/// Energy that has come in less what has left, since step 0.                                [J]
template <int D>
double energy_passed(const State<D>& state);
/// The same of momentum.                                                              [kg m/s]
template <int D>
Vec<D> momentum_passed(const State<D>& state);

}  // namespace bipot
