#include "core/scene/scene.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(Scene, SmallestRadiusIsThatOfAllDisks) {
  Scene<2> scene;
  EXPECT_EQ(smallest_radius(scene), kInfinity);
  for (const double radius : {0.3, 0.1, 0.2}) {
    scene.bodies.emplace_back();
    scene.bodies.back().radius = radius;
  }
  EXPECT_EQ(smallest_radius(scene), 0.1);
}

}  // namespace
}  // namespace bipot
