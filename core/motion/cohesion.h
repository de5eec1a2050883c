#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/motion/state.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// Cohesion of each contact of a step; empty in scenes without. It acts up to the scene's detection
/// distance, and where the scene does not heal at bonds alone: contacts with cohesion in the step
/// before. `state`: before the step. At time 0 every contact is a bond. `contacts` are those at
/// mid-step, sorted by (i, j).                                                              [N]
template <int D>
std::vector<double> cohesive_forces(const Scene<D>& scene,
                                    std::span<const std::type_identity_t<Body<D>>> bodies,
                                    std::span<const std::type_identity_t<Wall<D>>> walls,
                                    std::span<const std::type_identity_t<Contact<D>>> contacts,
                                    const State<D>& state);

}  // namespace bipot
