#include "core/motion/sample_volume.h"

#include "core/scene/scene_parts.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(ConvexBody, IsCutByPlanes) {
  ConvexBody body(Vec3::Zero(), Vec3(2, 3, 4));
  EXPECT_NEAR(body.volume(), 24, 1e-12);
  body.clip(Vec3(0, 0, 5), -Vec3::UnitZ());  // above it
  EXPECT_NEAR(body.volume(), 24, 1e-12);
  body.clip(Vec3(0, 0, 4), -Vec3::UnitZ());  // touches it
  EXPECT_NEAR(body.volume(), 24, 1e-12);
  body.clip(Vec3(0, 0, 1), -Vec3::UnitZ());
  EXPECT_NEAR(body.volume(), 6, 1e-12);
  // Along a diagonal, through four corners: half is left.
  body.clip(Vec3::Zero(), Vec3(3, -2, 0).normalized());
  EXPECT_NEAR(body.volume(), 3, 1e-12);
  body.clip(Vec3(9, 9, 9), Vec3::UnitX());
  EXPECT_NEAR(body.volume(), 0, 1e-12);
}

// The corner of a cube of edge 1 that a plane through three of its corners cuts off is a sixth.
TEST(ConvexBody, LosesACorner) {
  ConvexBody body(Vec3::Zero(), Vec3::Ones());
  body.clip(Vec3::UnitX(), Vec3(1, 1, 1).normalized());
  EXPECT_NEAR(body.volume(), 5.0 / 6, 1e-12);
}

TEST(SampleVolume, IsWhatWallsEnclose) {
  State<3> state;
  state.bodies = {round_body<3>(Vec3(1, 1, 1), 1, 2, Vec3(0, 0, 3)),
                  round_body<3>(Vec3(1, 3, 1), 1, 2, Vec3(0, 0, 3))};
  state.walls = {
      half_space<3>(Vec3::Zero(), Vec3::UnitX()),   half_space<3>(Vec3::Zero(), Vec3::UnitY()),
      half_space<3>(Vec3::Zero(), Vec3::UnitZ()),   half_space<3>(Vec3(2, 0, 0), -Vec3::UnitX()),
      half_space<3>(Vec3(0, 5, 0), -Vec3::UnitY()), half_space<3>(Vec3(0, 0, 4), -Vec3::UnitZ())};
  EXPECT_NEAR(sample_measure(state, 0), 2 * 5 * 4, 1e-10);
  // A lid that moves counts where it was at mid-step, half of 0.1 s x 2 m/s before.
  state.walls[5].v = Vec3(0, 0, 2);
  EXPECT_NEAR(sample_measure(state, 0.1), 2 * 5 * (4 - 0.1), 1e-10);
  EXPECT_EQ(sample_measure(State<3>{}, 0), 0);
}

// A pipe of radius 3 m that a floor and a lid close: π r² h. Without the lid nothing is enclosed.
TEST(SampleVolume, IsWhatAPipeEncloses) {
  State<3> state{.bodies = {round_body<3>(Vec3(6, 5, 1), 0.5, 2)}};
  Wall<3> pipe = half_space<3>(Vec3(5, 5, 9), Vec3::UnitZ());
  pipe.shape = Wall<3>::Shape::kHollowCircle;
  pipe.radius = 3;
  state.walls = {pipe, half_space<3>(Vec3::Zero(), Vec3::UnitZ()),
                 half_space<3>(Vec3(0, 0, 4), -Vec3::UnitZ())};
  EXPECT_NEAR(sample_measure(state, 0), std::numbers::pi * 9 * 4, 1e-9);
  state.walls[2].present = false;
  EXPECT_LT(sample_measure(state, 0), 1);
}

// One sphere counts exactly. A row of two, 4 m apart: its length times the round cross-section, and
// the two caps. 642 directions lie 0.14 apart, 46 around the row: polygons of 46 corners would miss
// (2π/46)²/6 = 0.3 % of the round, and the radius is chosen 0.3 % larger for the sphere.
TEST(SampleVolume, IsNearlyTheHullWithoutWalls) {
  const double round = 4 * std::numbers::pi / 3 * 8;
  State<3> state{.bodies = {round_body<3>(Vec3(5, 6, 7), 2, 2)}};
  EXPECT_NEAR(sample_measure(state, 0), round, 1e-12 * round);
  state.walls = {half_space<3>(Vec3(0, 0, 5), Vec3::UnitZ())};  // a floor encloses nothing
  EXPECT_NEAR(sample_measure(state, 0), round, 1e-12 * round);
  state.bodies.push_back(round_body<3>(Vec3(9, 6, 7), 2, 2));
  const double row = round + 4 * std::numbers::pi * 4;
  EXPECT_NEAR(sample_measure(state, 0), row, 0.01 * row);
}

// Eight spheres of radius 1e-3 at the corners of a box of 1 x 2 x 3 m: the box, its six faces times
// the radius (22 m²), the edges as quarters of cylinders (24 m, 2e-5) and one sphere.
TEST(SampleVolume, OfABoxOfSpheresIsTheBox) {
  State<3> state;
  for (int k = 0; k < 8; ++k) {
    state.bodies.push_back(round_body<3>(Vec3(k & 1, k & 2, 0.75 * (k & 4)), 1e-3, 2));
  }
  EXPECT_NEAR(sample_measure(state, 0), 6 + 22e-3 + 2e-5, 0.01 * 22e-3);
}

// 500 spheres on a spiral around a ball of radius 10 m: between the ball itself and that of radius
// 11 m, and as large as the hull of their centres (a ball, less 2 % for its 500 corners) and 1 m.
TEST(SampleVolume, OfAShellOfSpheres) {
  State<3> state;
  for (int k = 0; k < 500; ++k) {
    const double height = 1 - (2 * k + 1.0) / 500, angle = k * 2.399963;
    const double width = std::sqrt(1 - height * height);
    state.bodies.push_back(
        round_body<3>(10 * Vec3(width * std::cos(angle), width * std::sin(angle), height), 1, 2));
  }
  const double ball = 4 * std::numbers::pi / 3 * 1331;
  EXPECT_GT(sample_measure(state, 0), 0.97 * ball);
  EXPECT_LT(sample_measure(state, 0), 1.005 * ball);
}

// Planes that touch a sample touch its outermost spheres: it does not matter what lies within. The
// shell of a cube of spheres is the same sample with and without a filling of spheres that are as
// large or smaller, moved as a whole or not; a larger one within that sticks out counts.
TEST(SampleVolume, IsTheSameToTheBitWithAndWithoutWhatLiesWithin) {
  for (const double shift : {0.0, 13.7}) {
    State<3> shell, full;
    for (int k = 0; k < 7 * 7 * 7; ++k) {
      const Vec3 cell(k / 49 - 3, k / 7 % 7 - 3, k % 7 - 3);
      const bool rim = cell.cwiseAbs().maxCoeff() == 3;
      const Sphere s =
          round_body<3>(cell + Vec3(shift, -shift, 2 * shift), rim ? 0.5 : 0.5 - 0.01 * (k % 9), 2);
      if (rim) shell.bodies.push_back(s);
      full.bodies.push_back(s);
    }
    EXPECT_EQ(sample_measure(full, 0.01), sample_measure(shell, 0.01));
    const Sphere large = round_body<3>(Vec3(0, 1, 0) + Vec3(shift, -shift, 2 * shift), 4, 2);
    full.bodies.push_back(large);
    shell.bodies.push_back(large);
    EXPECT_EQ(sample_measure(full, 0.01), sample_measure(shell, 0.01));
    EXPECT_GT(sample_measure(full, 0.01), 7 * 7 * 7);
  }
}

}  // namespace
}  // namespace bipot
