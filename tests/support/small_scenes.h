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

/// A floor, a wall to the left and one to the right, and a lid.
inline std::vector<Wall<2>> box_walls(const Vec2& lower, const Vec2& upper) {
  return {half_space<2>(lower, Vec2(0, 1), "floor"), half_space<2>(lower, Vec2(1, 0)),
          half_space<2>(upper, Vec2(-1, 0)), half_space<2>(upper, Vec2(0, -1))};
}

/// Such a box from the origin on, without its lid.
inline std::vector<Wall<2>> trough(double width) {
  std::vector<Wall<2>> walls = box_walls(Vec2::Zero(), Vec2(width, 0));
  walls.pop_back();
  return walls;
}

}  // namespace bipot
