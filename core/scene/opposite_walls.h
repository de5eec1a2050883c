#pragma once

#include <string>

#include "core/scene/scene.h"

namespace bipot {

/// One sentence about each pair of opposite walls whose forces, with the weight of the bodies, do
/// not balance: they accelerate the whole sample. Empty: none. Scenes whose bodies come and go, or
/// whose gravity turns, are not looked at.
template <int D>
std::string unbalanced_walls(const Scene<D>& scene);

}  // namespace bipot
