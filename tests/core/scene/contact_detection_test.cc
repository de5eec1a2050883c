#include "core/scene/contact_detection.h"

#include "core/base/portable_random.h"
#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

bool by_pair(const Contact<2>& a, const Contact<2>& b) {
  return std::pair(a.i, a.j) < std::pair(b.i, b.j);
}

/// Every pair, no grid, and half-planes.
template <int D>
std::vector<Contact<D>> brute_force(const std::vector<Body<D>>& bodies,
                                    const std::vector<Wall<D>>& walls, double eta) {
  std::vector<Contact<D>> found;
  const int count = static_cast<int>(bodies.size());
  for (int i = 0; i < count; ++i) {
    const Body<D>& a = bodies[i];
    for (int j = i + 1; j < count; ++j) {
      const Vec<D> d = a.x - bodies[j].x;
      const double gap = d.norm() - a.radius - bodies[j].radius;
      if (gap <= eta) found.push_back({i, j, d.normalized(), gap});
    }
    for (std::size_t w = 0; w < walls.size(); ++w) {
      const double gap = walls[w].normal.dot(a.x - walls[w].a) - a.radius;
      if (gap <= eta) found.push_back({i, count + static_cast<int>(w), walls[w].normal, gap});
    }
  }
  return found;
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

/// `far`: of the bodies from the origin.
template <int D>
void expect_all_found(const std::vector<Body<D>>& bodies, double eta,
                      const std::vector<Wall<D>>& walls = {}, double far = 0) {
  const std::vector<Contact<D>> expected = brute_force<D>(bodies, walls, eta);
  const std::vector<Contact<D>> found = detect_contacts<D>(bodies, walls, eta);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Contact<D>& c = found[k];
    ASSERT_EQ(c.i, expected[k].i);
    ASSERT_EQ(c.j, expected[k].j);
    const double other = to_size(c.j) < bodies.size() ? bodies[c.j].radius : 0;
    EXPECT_NEAR(c.gap, expected[k].gap, 1e-13 * (bodies[c.i].radius + other + 10 * far));
    EXPECT_LT((c.n - expected[k].n).norm(), 1e-14);  // from j to i
  }
}

TEST(Detection, FindsEveryPairForAnyRatioOfRadii) {
  for (const double ratio : {1.5, 10.0, 100.0, 1000.0}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const std::vector<Disk> disks = power_law_disks(800, ratio, 2.2, seed);
      expect_all_found<2>(disks, 0);
      expect_all_found<2>(disks, 0.3);
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
    expect_all_found<2>(disks, 0.01);
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

TEST(Detection, EtaMayExceedTheDisks) { expect_all_found<2>(power_law_disks(100, 3, 2, 6), 50.0); }

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
  const std::vector<Sphere> spheres = {{.radius = 1}, {.radius = 0.5}};
  EXPECT_THROW(detect_contacts<3>(spheres, {}, 0), std::invalid_argument);
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

/// Radii between 1 and `ratio`, log-uniform, in a cube about `centre`.
std::vector<Sphere> cloud(int count, double ratio, double width, const Vec3& centre,
                          unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Sphere> spheres;
  for (int k = 0; k < count; ++k) {
    const Vec3 x(unit(random), unit(random), unit(random));
    spheres.push_back(round_body<3>(centre + width * (x - Vec3::Constant(0.5)),
                                    std::pow(ratio, unit(random)), 2));
  }
  return spheres;
}

// Equal spheres, sizes that fill several levels of the grid, negative coordinates, and coordinates
// far beyond the cells that a key can tell apart: 2^20 cells of 2 m in each direction.
TEST(SphereDetection, FindsWhatBruteForceFinds) {
  const std::vector<Wall<3>> walls = {half_space<3>(Vec3(0, 0, -9), Vec3::UnitZ()),
                                      half_space<3>(Vec3(8, 8, 0), Vec3(-1, -1, 0).normalized())};
  for (const double ratio : {1.0, 3.0, 40.0}) {
    for (const double far : {0.0, 1e7}) {
      const auto spheres = cloud(400, ratio, 20 * std::sqrt(ratio), Vec3(far, -far, far), 7);
      ASSERT_GT(detect_contacts<3>(spheres, walls, 0.1).size(), 100u) << ratio << " at " << far;
      expect_all_found<3>(spheres, 0.1, walls, far);
    }
  }
}

TEST(SphereDetection, ThreadsChangeNoBit) {
  const auto spheres = cloud(5000, 4, 60, Vec3::Zero(), 3);
  const std::vector<Wall<3>> walls = {half_space<3>(Vec3(0, 0, -20), Vec3::UnitZ())};
  const auto one = detect_contacts<3>(spheres, walls, 0.2, 1);
  const auto many = detect_contacts<3>(spheres, walls, 0.2, 4);
  ASSERT_EQ(one.size(), many.size());
  ASSERT_GT(one.size(), 1000u);
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_EQ(one[k].i, many[k].i);
    EXPECT_EQ(one[k].j, many[k].j);
    EXPECT_EQ(one[k].gap, many[k].gap);
    EXPECT_EQ(one[k].n, many[k].n);
  }
}

// Right-handed, orthonormal, for directions of all octants and the poles, where the formula's sign
// changes.
TEST(ContactFrame, IsRightHandedAndOrthonormal) {
  std::vector<Vec3> normals = {Vec3::UnitX(),
                               Vec3::UnitY(),
                               Vec3::UnitZ(),
                               -Vec3::UnitX(),
                               -Vec3::UnitY(),
                               -Vec3::UnitZ(),
                               Vec3(1, 1, -1e-17).normalized(),
                               Vec3(1e-9, 0, -1).normalized()};
  for (const Sphere& s : cloud(100, 2, 2, Vec3::Zero(), 5)) normals.push_back(s.x.normalized());
  for (const Vec3& n : normals) {
    const auto frame = contact_frame<3>(n);
    Eigen::Matrix3d basis;
    basis << frame[0], frame[1], frame[2];
    EXPECT_EQ(frame[0], n);
    EXPECT_LT((basis.transpose() * basis - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_NEAR(basis.determinant(), 1, 1e-14);
  }
}

}  // namespace
}  // namespace bipot
