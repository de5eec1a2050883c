#pragma once

#include <string>

namespace bipot {

/// Part of a scene's text: a floor through the origin, friction 0.5, and the time steps.
inline std::string floor_text(int steps) {
  return R"(
[contact]
mu = 0.5
[[walls]]
name = "floor"
point = [0, 0]
normal = [0, 1]
[time]
step = 0.01
steps = )" +
         std::to_string(steps) + "\n";
}

}  // namespace bipot
