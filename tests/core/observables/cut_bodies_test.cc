#include "core/observables/cut_bodies.h"

#include "core/base/portable_random.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(CutBodies, AreaInARectangleAgainstCountedPoints) {
  // Against counting 400 x 400 points of the rectangle: good to 1 % of the disk.
  PortableRandom draw(2);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec2 x(draw.symmetric(), draw.symmetric());
    const double radius = draw.between(0.2, 1.5);
    const Vec2 low(draw.between(-1.5, 0.5), draw.between(-1.5, 0.5));
    const Vec2 high = low + Vec2(draw.between(0.1, 1.5), draw.between(0.1, 1.5));
    int inside = 0;
    constexpr int kPoints = 200;
    for (int a = 0; a < kPoints; ++a) {
      for (int b = 0; b < kPoints; ++b) {
        const Vec2 at =
            low + (high - low).cwiseProduct(Vec2((a + 0.5) / kPoints, (b + 0.5) / kPoints));
        inside += (at - x).norm() < radius ? 1 : 0;
      }
    }
    const double expected = (high - low).prod() * inside / (kPoints * kPoints);
    EXPECT_NEAR(part_in_box(x, radius, {low, high}), expected, 0.01 * (high - low).prod());
  }
}

TEST(CutBodies, AreaInARectangleByHand) {
  const double disk = std::numbers::pi * 4;
  const Vec2 far(10, 10);
  EXPECT_NEAR(part_in_box(Vec2(0, 0), 2, {-far, far}), disk, 1e-14);
  EXPECT_NEAR(part_in_box(Vec2(0, 0), 2, {Vec2::Zero(), far}), disk / 4, 1e-14);
  EXPECT_NEAR(part_in_box(Vec2(0, 0), 2, {Vec2(-10, 1), far}),
              4 * (std::numbers::pi / 3 - std::sqrt(3.0) / 4),
              1e-13);  // r² (θ - sin θ cos θ), θ = 60 degrees
  EXPECT_NEAR(part_in_box(Vec2(0, 0), 2, {Vec2(-0.1, -0.2), Vec2(0.3, 0.1)}), 0.4 * 0.3, 1e-14);
  EXPECT_EQ(part_in_box(Vec2(5, 0), 2, {-Vec2::Ones(), Vec2::Ones()}), 0);
}

TEST(CutBodies, VolumeInABoxByHand) {
  const double pi = std::numbers::pi, sphere = 4 * pi / 3 * 8;
  const Vec3 far(10, 10, 10), at(1, 2, 3);
  EXPECT_NEAR(part_in_box(at, 2, {-far, far}), sphere, 1e-13);
  const Vec3 none = Vec3::Constant(-kInfinity), all = Vec3::Constant(kInfinity);
  EXPECT_NEAR(part_in_box(at, 2, {none, all}), sphere, 1e-13);
  EXPECT_NEAR(part_in_box(at, 2, {at, far}), sphere / 8, 1e-13);
  for (int axis = 0; axis < 3; ++axis) {  // a cap of height h: π h² (3 r - h)/3
    Vec3 low = -far;
    low[axis] = at[axis] + 1.5;
    EXPECT_NEAR(part_in_box(at, 2, {low, far}), pi * 0.25 * 5.5 / 3, 1e-13);
    low[axis] = at[axis] - 1.5;
    EXPECT_NEAR(part_in_box(at, 2, {low, far}), sphere - pi * 0.25 * 5.5 / 3, 1e-13);
  }
  // A box inside the sphere, one that holds nothing of it though its faces' planes cut it, and one
  // beside it.
  EXPECT_NEAR(part_in_box(at, 2, {at - Vec3(0.5, 0.3, 1), at + Vec3(1, 1, 0.9)}), 1.5 * 1.3 * 1.9,
              1e-13);
  EXPECT_EQ(part_in_box(at, 2, {at + Vec3(1.3, 1.3, 1.3), at + far}), 0);
  EXPECT_EQ(part_in_box(at, 2, {at + Vec3(2, -1, -1), at + Vec3(3, 1, 1)}), 0);
  // Planes through the centre at 45° would leave an eighth; a wedge along z of the quarter: a
  // fourth.
  EXPECT_NEAR(part_in_box(at, 2, {Vec3(1, 2, -10), far}), sphere / 4, 1e-13);
}

TEST(CutBodies, VolumeInABoxIsTheIntegralOfTheAreasOfItsSections) {
  // The rule of midpoints in θ, z = r sin θ, which takes the ends of the sphere without loss.
  PortableRandom draw(5);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 x(draw.symmetric(), draw.symmetric(), draw.symmetric());
    const double radius = draw.between(0.3, 1.5);
    const Vec3 low(draw.between(-1.5, 0.8), draw.between(-1.5, 0.8), draw.between(-1.5, 0.8));
    const Vec3 high = low + Vec3(draw.between(0.1, 2), draw.between(0.1, 2), draw.between(0.1, 2));
    const double from = std::asin(std::clamp((low[2] - x[2]) / radius, -1.0, 1.0));
    const double to = std::asin(std::clamp((high[2] - x[2]) / radius, -1.0, 1.0));
    double sum = 0;
    constexpr int kSlices = 4000;
    for (int k = 0; k < kSlices; ++k) {
      const double angle = from + (to - from) * (k + 0.5) / kSlices;
      const double section = radius * std::cos(angle);
      sum += part_in_box(Vec2(x.head<2>()), section, {low.head<2>(), high.head<2>()}) * section *
             (to - from) / kSlices;
    }
    EXPECT_NEAR(part_in_box(x, radius, {low, high}), sum, 2e-6) << trial;
  }
}

TEST(CutBodies, VolumesInBoxesThatTileSpaceAddUp) {
  PortableRandom draw(6);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 x(draw.symmetric(), draw.symmetric(), draw.symmetric());
    double sum = 0;
    const Vec3 cut(draw.symmetric(), draw.symmetric(), draw.symmetric());
    for (int which = 0; which < 8; ++which) {
      Vec3 low = Vec3::Constant(-kInfinity), high = Vec3::Constant(kInfinity);
      for (int axis = 0; axis < 3; ++axis) {
        ((which >> axis & 1) != 0 ? low : high)[axis] = cut[axis];
      }
      sum += part_in_box(x, 1.2, {low, high});
    }
    EXPECT_NEAR(sum, 4 * std::numbers::pi / 3 * 1.728, 1e-13);
  }
}

TEST(CutBodies, AreaCommonToTwoDisks) {
  const double pi = std::numbers::pi;
  EXPECT_EQ(area_in_disk(3, 1, 2), 0);
  EXPECT_NEAR(area_in_disk(1, 1, 2), pi, 1e-15);
  EXPECT_NEAR(area_in_disk(0, 2, 1), pi, 1e-15);
  // Two unit disks, one through the other's centre: 2 π/3 - √3/2.
  EXPECT_NEAR(area_in_disk(1, 1, 1), 2 * pi / 3 - std::sqrt(3.0) / 2, 1e-15);
  // Chord through the centre of the smaller one (1² + 1² = √2²): its half, and a segment of a right
  // angle.
  EXPECT_NEAR(area_in_disk(1, 1, std::sqrt(2.0)), pi / 2 + (pi / 2 - 1), 1e-14);
}

}  // namespace
}  // namespace bipot
