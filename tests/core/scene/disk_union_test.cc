#include "core/scene/disk_union.h"

#include "core/base/portable_random.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

constexpr double kPi = std::numbers::pi;

void expect_moments(const std::vector<Circle>& circles, double area, const Vec2& centre,
                    double polar, double accuracy) {
  const UnionMoments found = union_moments(circles);
  EXPECT_NEAR(found.area, area, accuracy * area);
  EXPECT_LT((found.centre - centre).norm(), accuracy * std::sqrt(area));
  EXPECT_NEAR(found.polar, polar, accuracy * polar);
}

/// The same by brute force: in each of many horizontal strips the union is a set of intervals. The
/// midpoint rule loses at the disks' tops, where the width has a root: accurate to strips^(-3/2).
UnionMoments by_strips(const std::vector<Circle>& circles, int strips) {
  double low = 1e300, high = -1e300;
  for (const Circle& c : circles) {
    low = std::min(low, c.centre[1] - c.radius);
    high = std::max(high, c.centre[1] + c.radius);
  }
  const double dy = (high - low) / strips;
  UnionMoments sum;
  Vec2 first = Vec2::Zero();
  double second = 0;
  for (int k = 0; k < strips; ++k) {
    const double y = low + (k + 0.5) * dy;
    std::vector<std::pair<double, double>> intervals;
    for (const Circle& c : circles) {
      const double half2 = c.radius * c.radius - (y - c.centre[1]) * (y - c.centre[1]);
      if (half2 <= 0) continue;
      intervals.emplace_back(c.centre[0] - std::sqrt(half2), c.centre[0] + std::sqrt(half2));
    }
    std::sort(intervals.begin(), intervals.end());
    double reached = -1e300;
    for (auto [from, to] : intervals) {
      from = std::max(from, reached);
      if (to <= from) continue;
      reached = to;
      sum.area += (to - from) * dy;
      first += dy * Vec2((to * to - from * from) / 2, (to - from) * y);
      second += dy * ((to * to * to - from * from * from) / 3 + (to - from) * y * y);
    }
  }
  sum.centre = first / sum.area;
  sum.polar = second - sum.area * sum.centre.squaredNorm();
  return sum;
}

TEST(DiskUnion, OneDiskAndDisksApart) {
  // A disk: π a², ½ π a⁴. Two apart: sums, with Steiner's m d² about the common centre.
  expect_moments({{Vec2(3, -2), 0.5}}, kPi / 4, Vec2(3, -2), kPi / 32, 1e-14);
  const double one = kPi, two = 4 * kPi;
  const Vec2 centre = (one * Vec2(0, 0) + two * Vec2(5, 5)) / (one + two);
  const double polar = kPi / 2 + one * centre.squaredNorm() + kPi / 2 * 16 +
                       two * (Vec2(5, 5) - centre).squaredNorm();
  expect_moments({{Vec2(0, 0), 1}, {Vec2(5, 5), 2}}, one + two, centre, polar, 1e-13);
}

TEST(DiskUnion, WhatLiesInsideAddsNothing) {
  expect_moments({{Vec2(1, 1), 2}, {Vec2(1.5, 1), 1}}, 4 * kPi, Vec2(1, 1), 8 * kPi, 1e-14);
  expect_moments({{Vec2(1, 1), 2}, {Vec2(1, 1), 2}}, 4 * kPi, Vec2(1, 1), 8 * kPi, 1e-14);
  expect_moments({{Vec2(1.5, 1), 1}, {Vec2(1, 1), 2}}, 4 * kPi, Vec2(1, 1), 8 * kPi, 1e-14);
}

TEST(DiskUnion, TwoThatOverlapAreTwoLessTheLens) {
  // Unit disks a distance d apart share a lens of 2 acos(d/2) - d/2 √(4 - d²). Its polar moment
  // about the middle: with the half angle w = acos(d/2) and c = d/2, a cap {x > c} of a unit disk
  // has
  //   ∫ dA = w - c s,   ∫ x dA = ⅔ s³,   ∫ (x² + y²) dA = (w - c s)/2 + ⅓ c s³,   s = sin w
  // about the disk's centre, hence about the middle (0 = c in the disk's frame, where the lens is
  // two caps)
  //   2 [ polar - 2 c ∫ x dA + c² ∫ dA ].
  for (const double d : {0.1, 0.7, 1.3, 1.99}) {
    const double c = d / 2, w = std::acos(c), s = std::sin(w);
    const double cap = w - c * s, moment = 2.0 / 3 * s * s * s;
    const double cap_polar = cap / 2 + c * s * s * s / 3;
    const double lens = 2 * cap;
    const double lens_polar = 2 * (cap_polar - 2 * c * moment + c * c * cap);
    const double polar = 2 * (kPi / 2 + kPi * c * c) - lens_polar;
    expect_moments({{Vec2(4 - c, 7), 1}, {Vec2(4 + c, 7), 1}}, 2 * kPi - lens, Vec2(4, 7), polar,
                   1e-13);
  }
}

TEST(DiskUnion, ManyWithHolesAsByStrips) {
  // A ring of eight around a hole, and a heap of unequal ones.
  std::vector<Circle> ring, heap;
  for (int k = 0; k < 8; ++k) {
    const double angle = kPi / 4 * k;
    ring.push_back({Vec2(std::cos(angle), std::sin(angle)), 0.45});
  }
  for (int k = 0; k < 12; ++k) {
    heap.push_back({Vec2(std::sin(3.7 * k), std::cos(5.1 * k)), 0.2 + 0.05 * (k % 5)});
  }
  heap.push_back({Vec2(9, 9), 0.5});
  for (const auto& circles : {ring, heap}) {
    const UnionMoments strips = by_strips(circles, 200000);
    expect_moments(circles, strips.area, strips.centre, strips.polar, 1e-6);
  }
  const double full = union_moments(ring).area;
  EXPECT_LT(full, 8 * kPi * 0.45 * 0.45);
  EXPECT_GT(full, kPi * (1.3 * 1.3 - 0.7 * 0.7) * 0.9);
}

TEST(DiskUnion, PartsInRectanglesThatTileAddUp) {
  // Of random unions, the parts in rectangles between two random lines along each axis; the whole
  // is union_moments().
  PortableRandom draw(3);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Circle> circles;
    const int count = 1 + trial % 6;
    for (int k = 0; k < count; ++k) {
      circles.push_back({Vec2(draw.symmetric(), draw.symmetric()), draw.between(0.1, 1)});
    }
    const Vec2 cut(draw.symmetric(), draw.symmetric());
    const Vec2 second = cut + Vec2(draw.between(0.1, 1), draw.between(0.1, 1));
    const double x[] = {-kInfinity, cut[0], second[0], kInfinity};
    const double y[] = {-kInfinity, cut[1], second[1], kInfinity};
    double sum = 0, inner = 0;
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        const double part = union_area_in(circles, Vec2(x[a], y[b]), Vec2(x[a + 1], y[b + 1]));
        sum += part;
        if (a == 1 && b == 1) inner = part;
      }
    }
    EXPECT_NEAR(sum, union_moments(circles).area, 1e-12) << trial;
    // Counted points in the inner rectangle: good to 2 % of it.
    int inside = 0;
    constexpr int kPoints = 100;
    for (int a = 0; a < kPoints; ++a) {
      for (int b = 0; b < kPoints; ++b) {
        const Vec2 at =
            cut + (second - cut).cwiseProduct(Vec2((a + 0.5) / kPoints, (b + 0.5) / kPoints));
        inside += std::any_of(circles.begin(), circles.end(),
                              [&](const Circle& c) { return (c.centre - at).norm() < c.radius; });
      }
    }
    EXPECT_NEAR(inner, (second - cut).prod() * inside / (kPoints * kPoints),
                0.02 * (second - cut).prod());
  }
}

TEST(DiskUnion, PartInARectangleByHand) {
  const std::vector<Circle> two = {{Vec2(-1, 0), 1}, {Vec2(1, 0), 1}};  // they touch at the origin
  const double pi = std::numbers::pi;
  EXPECT_NEAR(union_area_in(two, Vec2(-5, 0), Vec2(5, 5)), pi, 1e-14);
  EXPECT_NEAR(union_area_in(two, Vec2(-1, -5), Vec2(1, 5)), pi, 1e-14);
  EXPECT_NEAR(union_area_in(two, Vec2(-1.1, -0.1), Vec2(-0.9, 0.1)), 0.04, 1e-15);
  EXPECT_EQ(union_area_in(two, Vec2(-0.1, 0.9), Vec2(0.1, 1)), 0);
  EXPECT_EQ(union_area_in(two, Vec2(3, 3), Vec2(4, 4)), 0);
}

}  // namespace
}  // namespace bipot
