#pragma once

#include <string>

#include "core/scene/scene.h"

namespace bipot {

/// One sentence about each pair of opposite walls, half-planes or segments, whose forces, with the
/// weight of the bodies, differ by more than 1e-3 of the larger: they accelerate the whole sample.
/// Empty: none. Scenes whose bodies come and go, or
/// whose gravity turns, are not looked at.
template <int D>
std::string unbalanced_walls(const Scene<D>& scene);

}  // namespace bipot
