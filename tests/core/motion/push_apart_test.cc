#include "core/motion/push_apart.h"

#include "core/scene/scene_parts.h"
#include "core/scene/start_check.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"
#include "tests/support/small_scenes.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

template <int D>
PushApart pushed(Scene<D>& scene) {
  scene.step = 1e-3;
  SolverChoice choice{.tol = 1e-9};
  return push_apart(scene, make_step_solver(require_solver("auto"), to_options(choice)));
}

TEST(PushApart, TheLighterDiskGoesFarther) {
  // They overlap by 0.3 along x. Least ½ (m₁ d₁² + m₂ d₂²) with d₁ + d₂ = 0.3: d₁ / d₂ = m₂ / m₁.
  Scene<2> scene = one_law<2>({});
  scene.bodies = {round_body<2>(Vec2(0, 0), 1, 1), round_body<2>(Vec2(1.7, 0), 1, 2)};
  scene.bodies[0].v = Vec2(3, 0);
  const PushApart done = pushed(scene);
  EXPECT_NEAR(scene.bodies[0].x[0], -0.2, 1e-6);
  EXPECT_NEAR(scene.bodies[1].x[0], 1.8, 1e-6);
  EXPECT_EQ(done.rounds, 1);
  EXPECT_NEAR(done.way, 0.2, 1e-6);
  EXPECT_NEAR(done.radii, 0.2, 1e-6);
  EXPECT_EQ(scene.bodies[0].v, Vec2(3, 0));  // velocities are those of the scene
}

TEST(PushApart, AFillingBehindAWallComesBeforeItAndStaysApart) {
  Scene<2> scene = one_law<2>({.mu = 0.5});
  scene.walls = {half_space<2>(Vec2(0, 0), Vec2(0, 1)), half_space<2>(Vec2(-1, 0), Vec2(1, 0)),
                 half_space<2>(Vec2(1, 0), Vec2(-1, 0))};
  for (int row = 0; row < 6; ++row) {
    for (int k = 0; k < 8; ++k) {
      const double x = -0.9 + 0.24 * k + 0.03 * (row % 2);
      scene.bodies.push_back(round_body<2>(Vec2(x, -0.3 + 0.19 * row), 0.1, 1));
    }
  }
  EXPECT_FALSE(start_overlaps(scene).empty());
  const PushApart done = pushed(scene);
  EXPECT_TRUE(start_overlaps(scene).empty()) << start_sentence(scene, start_overlaps(scene));
  EXPECT_GE(done.rounds, 1);
  EXPECT_GE(done.way, 0.4 - 1e-6);  // the lowest row: from -0.3 to at least 0.1
}

// Rows up to a height of 3.05 under a lid at 2.3: 7.5 radii, more than a linearised step can bridge.
// Disks fill 96 π 0.1² / (2 · 2.3), two thirds of the box.
TEST(PushApart, AFillingFarAboveItsLidIsPressedIntoTheBox) {
  Scene<2> scene = one_law<2>({});
  scene.walls = box_walls(Vec2(-1, 0), Vec2(1, 2.3));
  for (int row = 0; row < 12; ++row) {
    for (int k = 0; k < 8; ++k) {
      const double x = -0.89 + 0.24 * k + 0.05 * (row % 3) - 0.002 * k;
      scene.bodies.push_back(round_body<2>(Vec2(x, 0.2 + 0.25 * row), 0.1, 1));
    }
  }
  const PushApart done = pushed(scene);
  EXPECT_TRUE(start_overlaps(scene).empty())
      << done.message << start_sentence(scene, start_overlaps(scene));
  EXPECT_GT(done.rounds, 7);
}

// The lid with its weight would give way as easily as the disk, by the least displacement in energy.
TEST(PushApart, DrivenWallsStay) {
  Scene<2> scene = one_law<2>({});
  Wall<2> lid = half_space<2>(Vec2(0, 1), Vec2(0, -1), "lid");
  drive(lid, Vec2(0, -1), 1);
  scene.walls = {lid};
  scene.bodies = {round_body<2>(Vec2(0, 0.8), 0.5, 1)};
  pushed(scene);
  EXPECT_EQ(scene.walls[0].a, Vec2(0, 1));
  EXPECT_EQ(scene.walls[0].motion, Wall<2>::Motion::kDriven);
  EXPECT_NEAR(scene.bodies[0].x[1], 0.5, 1e-6);
}

TEST(PushApart, ASphereIsPushedOutOfAPlaneAndWhatDoesNotFitRemains) {
  Scene<3> scene = one_law<3>({});
  scene.walls = {flat_floor<3>()};
  scene.bodies = {round_body<3>(Vec3(0, 0, 0.3), 0.5, 1)};
  pushed(scene);
  EXPECT_NEAR(scene.bodies[0].x[2], 0.5, 1e-6);
  // Between two planes 0.8 apart there is no room for a diameter of 1.
  scene.walls.push_back(half_space<3>(Vec3(0, 0, 0.8), Vec3(0, 0, -1), "lid"));
  const PushApart done = pushed(scene);
  EXPECT_FALSE(start_overlaps(scene).empty());
  EXPECT_NE(done.message, "");
}

}  // namespace
}  // namespace bipot
