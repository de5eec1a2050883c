#pragma once

#include <string>
#include <variant>

#include "core/scene_files/scene_file.h"

namespace bipot {

/// The scene of a text, of this dimension; messages call it test.toml.
template <int D = 2>
Scene<D> scene_of(const std::string& text) {
  return std::get<Scene<D>>(parse_any_scene(text, "test.toml"));
}

/// Part of a scene's text: a floor through the origin, friction 0.5, and the time steps.
inline std::string floor_text(int steps) {
  return R"(
contact = {mu = 0.5}
walls = [{name = "floor", point = [0, 0], normal = [0, 1]}]
time = {step = 0.01, steps = )" +
         std::to_string(steps) + "}\n";
}

}  // namespace bipot
