#include "core/motion/sample_area.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

Disk still_disk(double x, double y, double radius) { return {.x = Vec2(x, y), .radius = radius}; }

TEST(SampleArea, OfDisksWithoutWallsIsThatOfTheirHullWhateverLiesInside) {
  // Nine disks of radius 1 on a square of side 8: its hull is the square and its border of width 1,
  // rounded at the corners, 64 + 4 * 8 + pi, of which 256 points of a circle show all but
  // pi - 128 sin(2 pi / 256).
  State<2> square;
  for (const double x : {0.0, 4.0, 8.0}) {
    for (const double y : {0.0, 4.0, 8.0}) square.bodies.push_back(still_disk(x, y, 1));
  }
  EXPECT_NEAR(sample_measure(square, 1e-3), 64 + 32 + 128 * std::sin(2 * std::numbers::pi / 256),
              1e-12);
  // A cloud of disks of 0.1 to 1 m: those well inside change no bit, wherever in the list they
  // stand.
  State<2> cloud, rim;
  for (int k = 0; k < 4000; ++k) {
    const double angle = 2.4 * k, distance = 30 * std::sqrt(k / 4000.0);
    Disk d = still_disk(distance * std::cos(angle), 0.6 * distance * std::sin(angle),
                        0.1 + 0.9 * (k % 7) / 6);
    d.v = Vec2(std::sin(3.0 * k), 0);
    cloud.bodies.push_back(d);
    if (distance > 24) rim.bodies.push_back(d);
  }
  EXPECT_LT(rim.bodies.size(), cloud.bodies.size() / 2);
  EXPECT_EQ(sample_measure(cloud, 1e-3), sample_measure(rim, 1e-3));
  // One disk that is as large as everything hides the others.
  cloud.bodies.push_back(still_disk(0, 0, 100));
  EXPECT_NEAR(sample_measure(cloud, 1e-3), 1e4 * 128 * std::sin(2 * std::numbers::pi / 256), 1e-8);
}

/// Area of the hull of equal disks with these centres of a convex polygon, anticlockwise: area A,
/// length L give A + L r + π r².
double rounded_area(const std::vector<Vec2>& corners, double radius) {
  double twice = 0, length = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec2 &p = corners[k], &q = corners[(k + 1) % corners.size()];
    twice += p[0] * q[1] - p[1] * q[0];
    length += (q - p).norm();
  }
  return 0.5 * twice + length * radius + std::numbers::pi * radius * radius;
}

TEST(SampleArea, HasEveryDiskThatProtrudes) {
  // The second disk protrudes by 5 mm, in a range of directions narrower than 1/256 of a turn; so
  // narrow is that of each of 1000 disks on a circle. Rims of 256 points reach less far than disks
  // by at most r π²/(2·256²) = 7.6e-5 r, along a hull shorter than 7 m.
  std::vector<Vec2> circle;
  for (int k = 0; k < 1000; ++k) {
    const double angle = 2 * std::numbers::pi * k / 1000;
    circle.emplace_back(std::cos(angle), std::sin(angle));
  }
  const std::vector<Vec2> flat = {{-1, 0}, {0, 0.00725}, {1, 0.0245}, {0, 0.2}};
  for (const auto& [corners, radius] : {std::pair(flat, 0.01), std::pair(circle, 1e-3)}) {
    for (const double angle : {0.0, 0.01, 1.0, 2.0}) {
      State<2> state;
      const Eigen::Rotation2D<double> turn(angle);
      std::vector<Vec2> places = corners;
      places.emplace_back(0, 0.05);  // inside
      for (const Vec2& at : places) {
        const Vec2 x = turn * at;
        state.bodies.push_back(still_disk(x[0], x[1], radius));
      }
      const double area = rounded_area(corners, radius);
      EXPECT_NEAR(sample_measure(state, 1e-3), area, 8e-5 * 7 * radius) << angle;
    }
  }
}

TEST(SampleArea, HasADiskBetweenTwoThatExtendEquallyFar) {
  // Two disks of radius 1 stand on a line, 10 apart; their hull is 20 + pi. At 45 degrees below the
  // second, d = 0.8 sqrt(2) away, a third of radius r = 0.15 does not reach the line. With t² = d² -
  // (1 - r)² and cos(phi) = (1 - r)/d its hull with the second is (1 + r) t + pi - phi + r² phi.
  const double d = 0.8 * std::numbers::sqrt2, r = 0.15, phi = std::acos((1 - r) / d);
  const double more = (1 + r) * std::sqrt(d * d - (1 - r) * (1 - r)) - phi + r * r * phi;
  for (const double side : {-1.0, 1.0}) {
    State<2> state{
        .bodies = {still_disk(0, 0, 1), still_disk(10, 0, 1), still_disk(10.8, 0.8 * side, r)}};
    EXPECT_NEAR(sample_measure(state, 1e-3), 20 + std::numbers::pi + more, 2e-3) << side;
  }
}

}  // namespace
}  // namespace bipot
