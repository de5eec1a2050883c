#include "core/scene/generators.h"

#include "core/scene/contact_detection.h"
#include "core/scene/scene_family.h"
#include "tests/support/bit_hash.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Of the bits of positions and radii.
std::uint64_t hash_of(const std::vector<Disk>& disks) {
  BitHash hash;
  for (const Disk& d : disks) {
    for (const double x : {d.x[0], d.x[1], d.radius}) hash.add(x);
  }
  return hash.value();
}

double lowest_gap(const std::vector<Disk>& disks) {
  double gap = 1e300;
  for (const Contact<2>& c : detect_contacts(disks, {}, disks[0].radius))
    gap = std::min(gap, c.gap);
  return gap;
}

int touching(const std::vector<Disk>& disks) {
  return static_cast<int>(detect_contacts(disks, {}, 1e-9 * disks[0].radius).size());
}

void expect_in_corner(const std::vector<Disk>& disks, const Vec2& corner) {
  Vec2 low(1e300, 1e300);
  for (const Disk& d : disks) low = low.cwiseMin(d.x - Vec2(d.radius, d.radius));
  EXPECT_NEAR((low - corner).norm(), 0, 1e-14);
}

/// 10 rows of 20 and 10 of 19: 370 contacts in rows, 2 * 19 * 19 between them, 20 with the floor,
/// 10 with the left wall.
TEST(Generators, TheTrapezoidIsFreeOnTheRight) {
  const Scene<2> scene = make_family_scene("trapezoid", 20, {.tilt_degrees = 10});
  EXPECT_EQ(scene.bodies.size(), 390u);
  EXPECT_EQ(scene.walls.size(), 2u);
  EXPECT_EQ(detect_contacts(scene.bodies, scene.walls, scene.contact_distance).size(), 1122u);
  EXPECT_GT(scene.gravity.x(), 0);
}

TEST(Generators, RectangularLatticeTouchesItsFourNeighbours) {
  const auto disks = rectangular_lattice(5, 3, 0.02, Vec2(1, -2));
  ASSERT_EQ(disks.size(), 15u);
  EXPECT_EQ(touching(disks), 4 * 3 + 5 * 2);
  EXPECT_GT(lowest_gap(disks), -1e-15);
  expect_in_corner(disks, Vec2(1, -2));
  EXPECT_TRUE(disks[1].x.isApprox(Vec2(1.06, -1.98)));  // row by row from the bottom
}

TEST(Generators, TriangularLatticeAlternatesItsRows) {
  const auto disks = triangular_lattice(5, 4, 0.02, Vec2(1, -2));
  ASSERT_EQ(disks.size(), 5u + 4 + 5 + 4);
  // In rows 4 + 3 + 4 + 3, between rows 8 each (each disk of a short row has two below, two above).
  EXPECT_EQ(touching(disks), 14 + 3 * 8);
  EXPECT_GT(lowest_gap(disks), -1e-15);
  expect_in_corner(disks, Vec2(1, -2));
}

TEST(Generators, PyramidEndsInOneDisk) {
  const auto disks = pyramid(5, 0.02, Vec2(1, -2));
  ASSERT_EQ(disks.size(), 15u);
  EXPECT_EQ(touching(disks), (4 + 3 + 2 + 1) + 2 * (4 + 3 + 2 + 1));
  EXPECT_GT(lowest_gap(disks), -1e-15);
  expect_in_corner(disks, Vec2(1, -2));
  EXPECT_NEAR(disks.back().x[0], 1.1, 1e-15);
  EXPECT_NEAR(disks.back().x[1], -2 + 0.02 + 4 * std::sqrt(3.0) * 0.02, 1e-15);
}

TEST(Generators, EmptyLattices) {
  EXPECT_TRUE(rectangular_lattice(0, 3, 1, Vec2::Zero()).empty());
  EXPECT_TRUE(triangular_lattice(3, 0, 1, Vec2::Zero()).empty());
  EXPECT_TRUE(pyramid(0, 1, Vec2::Zero()).empty());
  EXPECT_TRUE(random_filling(0, {{1, 1}}, 10, 0, 1, Vec2::Zero()).empty());
}

TEST(Generators, RandomFillingDoesNotOverlapAndStaysWithinItsWidth) {
  for (const double spacing : {0.0, 0.1}) {
    const auto disks =
        random_filling(1000, {{0.5, 1}, {0.75, 2}, {1, 1}}, 41.3, spacing, 7, Vec2(-3, 2));
    ASSERT_EQ(disks.size(), 1000u);
    EXPECT_GE(lowest_gap(disks), -1e-12);
    for (const Disk& d : disks) {
      EXPECT_GE(d.x[0] - d.radius, -3 - 1e-12);
      EXPECT_LE(d.x[0] + d.radius, 38.3 + 1e-12);
      EXPECT_GE(d.x[1] - d.radius, 2 - 1e-12);
    }
  }
}

std::map<double, int> class_sizes(int count, const std::vector<RadiusClass>& classes) {
  std::map<double, int> sizes;
  for (const Disk& d : random_filling(count, classes, 100, 0, 3, Vec2::Zero())) ++sizes[d.radius];
  return sizes;
}

TEST(Generators, FractionsAreMetByLargestRemainders) {
  // The paper's 342 disks: 85.5, 171, 85.5; the tie goes to the class named first.
  EXPECT_EQ(class_sizes(342, {{0.65, 0.25}, {0.75, 0.5}, {0.9, 0.25}}),
            (std::map<double, int>{{0.65, 86}, {0.75, 171}, {0.9, 85}}));
  // 10 * (0.46, 0.27, 0.27) = 4.6, 2.7, 2.7: the remainders 0.7 come before 0.6.
  EXPECT_EQ(class_sizes(10, {{1, 0.46}, {2, 0.27}, {3, 0.27}}),
            (std::map<double, int>{{1, 4}, {2, 3}, {3, 3}}));
  // Fractions are relative.
  EXPECT_EQ(class_sizes(10, {{1, 3}, {2, 2}}), (std::map<double, int>{{1, 6}, {2, 4}}));
  EXPECT_EQ(class_sizes(7, {{1, 1}, {2, 0}}), (std::map<double, int>{{1, 7}}));
}

TEST(Generators, RandomFillingHasTheSameBitsEverywhere) {
  const std::vector<RadiusClass> classes = {{0.65e-3, 0.25}, {0.75e-3, 0.5}, {0.9e-3, 0.25}};
  const auto fill = [&](std::uint64_t seed) {
    return hash_of(random_filling(342, classes, 0.03, 0.05, seed, Vec2::Zero()));
  };
  EXPECT_EQ(fill(1), 16249260049424366586u);
  EXPECT_NE(fill(1), fill(2));
}

TEST(Generators, RefuseWhatCannotBeFilled) {
  const auto fill = [](int count, const std::vector<RadiusClass>& classes, double width,
                       double spacing) {
    return random_filling(count, classes, width, spacing, 1, Vec2::Zero());
  };
  EXPECT_THROW(fill(-1, {{1, 1}}, 10, 0), std::invalid_argument);
  EXPECT_THROW(fill(5, {}, 10, 0), std::invalid_argument);
  EXPECT_THROW(fill(5, {{0, 1}}, 10, 0), std::invalid_argument);
  EXPECT_THROW(fill(5, {{-1, 1}}, 10, 0), std::invalid_argument);
  EXPECT_THROW(fill(5, {{1, -1}}, 10, 0), std::invalid_argument);
  EXPECT_THROW(fill(5, {{1, 0}}, 10, 0), std::invalid_argument);
  EXPECT_THROW(fill(5, {{1, 1}}, 1.9, 0), std::invalid_argument);
  EXPECT_THROW(fill(5, {{1, 1}}, 10, -0.1), std::invalid_argument);
  // 5e223 columns are no int: found by tests/fuzz/scene_fuzz.cc.
  EXPECT_THROW(fill(5, {{1e-225, 1}}, 0.1, 0), std::invalid_argument);
}

}  // namespace
}  // namespace bipot
