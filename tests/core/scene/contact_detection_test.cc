#include "core/scene/contact_detection.h"

#include "core/base/portable_random.h"
#include "core/scene/generators.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

struct Pair {
  int i, j;
  double gap;
};

bool by_pair(const Contact<2>& a, const Contact<2>& b) {
  return std::pair(a.i, a.j) < std::pair(b.i, b.j);
}

/// Every pair, no grid.
std::vector<Pair> brute_force(const std::vector<Disk>& disks, double eta) {
  std::vector<Pair> pairs;
  for (int i = 0; i < static_cast<int>(disks.size()); ++i) {
    for (int j = i + 1; j < static_cast<int>(disks.size()); ++j) {
      const double gap = std::hypot(disks[i].x[0] - disks[j].x[0], disks[i].x[1] - disks[j].x[1]) -
                         disks[i].radius - disks[j].radius;
      if (gap <= eta) pairs.push_back({i, j, gap});
    }
  }
  return pairs;
}

/// Radii between `smallest` and ratio * smallest, number density falling as a power of the radius,
/// in a square of twice their radii's squares: they overlap a lot.
std::vector<Disk> power_law_disks(int count, double ratio, double exponent, unsigned seed) {
  PortableRandom draw(seed);
  std::vector<Disk> disks(count);
  double area = 0;
  for (Disk& d : disks) {
    // Inverse of the cumulative distribution of r^-exponent on [1, ratio].
    const double k = 1 - exponent;
    d.radius = std::pow(1 + draw.uniform() * (std::pow(ratio, k) - 1), 1 / k);
    area += d.radius * d.radius;
  }
  const double side = std::max(std::sqrt(0.5 * area), 0.5 * ratio);
  for (Disk& d : disks) d.x = Vec2(side * draw.symmetric(), side * draw.symmetric());
  return disks;
}

void expect_all_found(const std::vector<Disk>& disks, double eta) {
  const std::vector<Pair> expected = brute_force(disks, eta);
  const std::vector<Contact<2>> found = detect_contacts(disks, {}, eta);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Contact<2>& c = found[k];
    ASSERT_EQ(c.i, expected[k].i);
    ASSERT_EQ(c.j, expected[k].j);
    const double size = disks[c.i].radius + disks[c.j].radius;
    EXPECT_NEAR(c.gap, expected[k].gap, 1e-13 * size);
    EXPECT_NEAR(c.n.norm(), 1, 1e-15);
    // n points from j to i.
    EXPECT_NEAR((disks[c.i].x - disks[c.j].x - (size + c.gap) * c.n).norm(), 0, 1e-12 * size);
  }
}

TEST(Detection, FindsEveryPairForAnyRatioOfRadii) {
  for (const double ratio : {1.5, 10.0, 100.0, 1000.0}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const std::vector<Disk> disks = power_law_disks(800, ratio, 2.2, seed);
      expect_all_found(disks, 0);
      expect_all_found(disks, 0.3);
    }
  }
}

TEST(Detection, RadiiAtPowersOfTwoOfTheSmallest) {
  // The border of a size class belongs to it.
  for (const double shift : {0.0, 1e-16, -1e-16, 1e-12, -1e-12}) {
    std::vector<Disk> disks;
    double x = 0;
    for (int k = 0; k < 9; ++k) {
      Disk d{.radius = std::ldexp(0.1, k) * (1 + shift)};
      x += d.radius;
      d.x = Vec2(x, 0.01);
      x += d.radius;
      disks.push_back(d);
    }
    const std::vector<Contact<2>> contacts = detect_contacts(disks, {}, 1e-9);
    ASSERT_EQ(contacts.size(), 8u);
    for (int k = 0; k < 8; ++k) EXPECT_EQ(contacts[k].j, k + 1);
  }
}

TEST(Detection, WorksFarFromTheOriginAndBeyondTheGrid) {
  for (const double offset : {1e3, 1e8, 1e13}) {
    std::vector<Disk> disks = power_law_disks(200, 5, 2, 3);
    for (Disk& d : disks) d.x += Vec2(offset, -offset);
    // Coordinates are rounded out there: compare with the same rounded positions.
    bool coincident = false;
    for (std::size_t i = 0; i < disks.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) coincident |= disks[i].x == disks[j].x;
    }
    ASSERT_FALSE(coincident);
    const std::vector<Pair> expected = brute_force(disks, 0.01);
    EXPECT_EQ(detect_contacts(disks, {}, 0.01).size(), expected.size()) << offset;
  }
}

TEST(Detection, TheOrderOfTheDisksDoesNotMatter) {
  const std::vector<Disk> disks = power_law_disks(300, 30, 2, 4);
  std::vector<int> order(disks.size());
  std::iota(order.begin(), order.end(), 0);
  PortableRandom draw(5);
  for (std::size_t k = order.size(); k > 1; --k) {
    std::swap(order[k - 1], order[draw.below(static_cast<int>(k))]);
  }
  std::vector<Disk> shuffled;
  for (int k : order) shuffled.push_back(disks[k]);
  const std::vector<Contact<2>> reference = detect_contacts(disks, {}, 0.1);
  std::vector<Contact<2>> back = detect_contacts(shuffled, {}, 0.1);
  ASSERT_EQ(back.size(), reference.size());
  ASSERT_GT(back.size(), 300u);
  for (Contact<2>& c : back) {
    c.i = order[c.i];
    c.j = order[c.j];
    if (c.i > c.j) {
      std::swap(c.i, c.j);
      c.n = -c.n;
    }
  }
  std::sort(back.begin(), back.end(), by_pair);
  for (std::size_t k = 0; k < back.size(); ++k) {
    EXPECT_EQ(back[k].i, reference[k].i);
    EXPECT_EQ(back[k].j, reference[k].j);
    EXPECT_EQ(back[k].n, reference[k].n);
    EXPECT_EQ(back[k].gap, reference[k].gap);
  }
}

TEST(Detection, EtaIsTheLargestGapOfACandidate) {
  std::vector<Disk> disks = {{.radius = 1}, {.x = Vec2(2.5, 0), .radius = 1}};
  EXPECT_EQ(detect_contacts(disks, {}, 0.499).size(), 0u);
  EXPECT_EQ(detect_contacts(disks, {}, 0.5).size(), 1u);
  disks[1].x = Vec2(2, 0);
  EXPECT_EQ(detect_contacts(disks, {}, 0).size(), 1u);  // touching counts
}

TEST(Detection, EtaMayExceedTheDisks) { expect_all_found(power_law_disks(100, 3, 2, 6), 50.0); }

std::vector<Disk> one_disk(const Vec2& x, double radius) { return {{.x = x, .radius = radius}}; }

TEST(Detection, HalfPlaneActsAlongItsNormal) {
  Wall<2> wall{.a = Vec2(5, 1), .normal = Vec2(0.6, 0.8)};
  // Distance of the centre from the line: 0.6 * (8 - 5) + 0.8 * (2 - 1) = 2.6.
  const std::vector<Contact<2>> contacts =
      detect_contacts(one_disk(Vec2(8, 2), 3), std::span(&wall, 1), 0);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].i, 0);
  EXPECT_EQ(contacts[0].j, 1);  // one disk: the wall is body 1
  EXPECT_EQ(contacts[0].n, wall.normal);
  EXPECT_NEAR(contacts[0].gap, -0.4, 1e-15);
  EXPECT_EQ(detect_contacts(one_disk(Vec2(8, 2), 2), std::span(&wall, 1), 0.5).size(), 0u);
  // A disk behind the line overlaps, however far it is.
  EXPECT_NEAR(detect_contacts(one_disk(Vec2(-100, 1), 1), std::span(&wall, 1), 0).at(0).gap, -64,
              1e-12);
}

TEST(Detection, SegmentHasTwoSidesAndTwoEnds) {
  Wall<2> wall{.shape = Wall<2>::Shape::kSegment, .a = Vec2(0, 0), .b = Vec2(4, 0)};
  const std::span<const Wall<2>> walls(&wall, 1);
  const auto only = [&](const Vec2& x) { return detect_contacts(one_disk(x, 1), walls, 0).at(0); };
  EXPECT_EQ(only(Vec2(2, 0.75)).n, Vec2(0, 1));
  EXPECT_EQ(only(Vec2(2, -0.75)).n, Vec2(0, -1));
  EXPECT_DOUBLE_EQ(only(Vec2(2, -0.75)).gap, -0.25);
  // Beyond the ends the end point is touched: (4.3, 0.4) is 0.5 away from (4, 0).
  EXPECT_TRUE(only(Vec2(4.3, 0.4)).n.isApprox(Vec2(0.6, 0.8)));
  EXPECT_NEAR(only(Vec2(4.3, 0.4)).gap, -0.5, 1e-15);
  EXPECT_TRUE(only(Vec2(-0.3, 0.4)).n.isApprox(Vec2(-0.6, 0.8)));
  EXPECT_EQ(only(Vec2(-0.5, 0)).n, Vec2(-1, 0));
  EXPECT_EQ(detect_contacts(one_disk(Vec2(5.01, 0), 1), walls, 0).size(), 0u);
  EXPECT_EQ(detect_contacts(one_disk(Vec2(5, 0), 1), walls, 0).size(), 1u);
}

TEST(Detection, DisksAndWallsAreSortedByPair) {
  const std::vector<Disk> disks = rectangular_lattice(4, 3, 0.5, Vec2::Zero());
  std::vector<Wall<2>> walls(2);
  walls[1].normal = Vec2(1, 0);
  const std::vector<Contact<2>> contacts = detect_contacts(disks, walls, 1e-9);
  EXPECT_EQ(contacts.size(), 3u * 3 + 4 * 2 + 4 + 3);
  EXPECT_TRUE(std::is_sorted(contacts.begin(), contacts.end(), by_pair));
  for (const Contact<2>& c : contacts) EXPECT_LT(c.i, c.j);
}

TEST(Detection, RefusesCoincidentCentres) {
  const std::vector<Disk> disks = {{.radius = 1}, {.radius = 200}};
  EXPECT_THROW(detect_contacts(disks, {}, 0), std::invalid_argument);
  Wall<2> wall{.shape = Wall<2>::Shape::kSegment, .a = Vec2(-1, 0), .b = Vec2(1, 0)};
  EXPECT_THROW(detect_contacts(one_disk(Vec2(0.5, 0), 1), std::span(&wall, 1), 0),
               std::invalid_argument);
}

TEST(Detection, NothingThereIsNothingFound) {
  EXPECT_TRUE(detect_contacts({}, {}, 0).empty());
  const Wall<2> wall;
  EXPECT_TRUE(detect_contacts({}, std::span(&wall, 1), 0).empty());
}

TEST(Detection, HundredThousandDisksOfPowerLawRadiiAreNoTrouble) {
  // All pairs would be 5e9 tests.
  const std::vector<Disk> disks = power_law_disks(100000, 1000, 2.5, 8);
  const auto start = std::chrono::steady_clock::now();
  const std::size_t found = detect_contacts(disks, {}, 0).size();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  EXPECT_GT(found, 100000u);
  EXPECT_LT(seconds.count(), 20);
}

}  // namespace
}  // namespace bipot
