#include "core/pictures/colour_map.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(ColourMap, LightnessFallsLinearlySoThatGreySuffices) {
  EXPECT_NEAR(lightness({1, 1, 1}), 1, 1e-6);
  EXPECT_NEAR(lightness({0, 0, 0}), 0, 1e-12);
  for (int k = 0; k <= 50; ++k) {
    const double at = k / 50.0;
    EXPECT_NEAR(lightness(sequential_colour(at)), 0.97 - 0.66 * at, 1e-6) << at;
  }
}

TEST(ColourMap, StaysWithinWhatAScreenShows) {
  for (int k = 0; k <= 200; ++k) {
    const Colour c = sequential_colour(k / 200.0);
    for (double x : {c.red, c.green, c.blue}) {
      EXPECT_GT(x, 0) << k;  // clamped values would bend the lightness
      EXPECT_LT(x, 1) << k;
    }
  }
}

TEST(ColourMap, BeyondItsEndsIsTheNearestEnd) {
  EXPECT_EQ(sequential_colour(-1).red, sequential_colour(0).red);
  EXPECT_EQ(sequential_colour(7).green, sequential_colour(1).green);
}

}  // namespace
}  // namespace bipot
