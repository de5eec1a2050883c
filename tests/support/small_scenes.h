#pragma once

#include <vector>

#include "core/scene/scene_parts.h"

namespace bipot {

/// A scene of one law, with gravity down the last axis and this step.
template <int D = 2>
Scene<D> heavy_scene(const ContactLaw& law, double step = 1e-3) {
  Scene<D> scene = one_law<D>(law);
  scene.gravity = -kGravity * Vec<D>::Unit(D - 1);
  scene.step = step;
  return scene;
}

/// The scene with a floor, and a body that touches it above the origin; `round`: its radius, mass,
/// velocity and spin.
template <int D, class... Round>
Scene<D> on_floor(Scene<D> scene, double radius, const Round&... round) {
  scene.walls = {flat_floor<D>()};
  scene.bodies = {round_body<D>(radius * Vec<D>::Unit(D - 1), radius, round...)};
  return scene;
}

/// A floor, a wall at x = 0 and one at the width.
inline std::vector<Wall<2>> trough(double width) {
  return {flat_floor<2>(), half_space<2>(Vec2::Zero(), Vec2(1, 0)),
          half_space<2>(Vec2(width, 0), Vec2(-1, 0))};
}

}  // namespace bipot
