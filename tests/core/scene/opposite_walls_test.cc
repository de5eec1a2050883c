#include "core/scene/opposite_walls.h"

#include "core/scene/scene_parts.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

Scene<2> pressed(double left, double right) {
  Scene<2> scene = one_law<2>({});
  scene.bodies = {round_body<2>(Vec2(0.5, 0.5), 0.5, 2)};
  scene.walls = {half_space<2>(Vec2(0, 0), Vec2(1, 0), "left"),
                 half_space<2>(Vec2(1, 0), Vec2(-1, 0), "right")};
  for (Wall<2>& wall : scene.walls) drive(wall, wall.normal, 1);
  scene.walls[0].force = left;
  scene.walls[1].force = right;
  return scene;
}

TEST(OppositeWalls, UnequalForcesArePointedOut) {
  EXPECT_EQ(unbalanced_walls(pressed(500, 500)), "");
  const std::string text = unbalanced_walls(pressed(500, 400));
  EXPECT_TRUE(says(text, "'left' and 'right'"));
  EXPECT_TRUE(says(text, " 100 N"));
}

// Segments of 1 m: only those that lie before each other press on the same bodies.
TEST(OppositeWalls, SegmentsCountAsWell) {
  Scene<2> scene = pressed(500, 400);
  for (Wall<2>& wall : scene.walls) {
    wall.shape = Wall<2>::Shape::kSegment;
    wall.b = wall.a + Vec2(0, 1);
  }
  EXPECT_TRUE(says(unbalanced_walls(scene), " 100 N"));
  Scene<2> away = scene;
  for (Wall<2>& wall : away.walls) wall.direction = -wall.direction;
  EXPECT_EQ(unbalanced_walls(away), "");
  scene.walls[0].a[1] += 1.5;
  scene.walls[0].b[1] += 1.5;
  EXPECT_EQ(unbalanced_walls(scene), "");
}

// Upright, the lower wall has the weight to bear as well: 2 kg · 10 m/s².
TEST(OppositeWalls, TheWeightCounts) {
  Scene<2> scene = pressed(520, 500);
  EXPECT_NE(unbalanced_walls(scene), "");
  scene.gravity = Vec2(-10, 0);
  EXPECT_EQ(unbalanced_walls(scene), "");
  scene.walls[0].motion = Wall<2>::Motion::kFixed;
  scene.walls[1].force = 3;
  EXPECT_EQ(unbalanced_walls(scene), "");  // a fixed wall bears anything
}

}  // namespace
}  // namespace bipot
