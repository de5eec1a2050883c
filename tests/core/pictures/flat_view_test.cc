#include "core/pictures/flat_view.h"

#include "core/motion/state.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// The middle of a cone, radius 0.2 at z = 0 and 1.2 at z = 1, cuts two lines, from x = ±0.2 to ±1.2.
/// It is drawn as a prism of 32 sides: up to 0.5 % narrower.
TEST(FlatView, AConeIsCutOnBothSidesAlsoAtTheSeamOfItsPrism) {
  Scene<3> scene{.gravity = Vec3(0, 0, -9.81)};
  Wall<3> cone{.name = "cone", .shape = Wall<3>::Shape::kCone, .a = Vec3::Zero()};
  cone.b = Vec3::UnitZ();
  cone.radius = 0.2;
  cone.radius_b = 1.2;
  scene.walls.push_back(cone);
  const std::vector<Wall<2>> lines = project(scene, initial_state(scene)).state.walls;
  ASSERT_EQ(lines.size(), 2u);
  double left = 0, right = 0;
  for (const Wall<2>& line : lines) {
    const Vec2 &low = line.a.y() < line.b.y() ? line.a : line.b,
               &high = line.a.y() < line.b.y() ? line.b : line.a;
    EXPECT_NEAR(low.y(), 0, 1e-12);
    EXPECT_NEAR(high.y(), 1, 1e-12);
    EXPECT_NEAR(std::abs(low.x()), 0.2, 0.005 * 0.2);
    EXPECT_NEAR(std::abs(high.x()), 1.2, 0.005 * 1.2);
    left = std::min(left, high.x());
    right = std::max(right, high.x());
  }
  EXPECT_LT(left, 0);
  EXPECT_GT(right, 0);
}

}  // namespace
}  // namespace bipot
