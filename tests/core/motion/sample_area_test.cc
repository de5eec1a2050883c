#include "core/motion/sample_area.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace bipot {
namespace {

Disk still_disk(double x, double y, double radius) {
  Disk d{.x = Vec2(x, y), .radius = radius};
  return d;
}

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

}  // namespace
}  // namespace bipot
