#include "core/scene/contact_detection.h"
#include "core/scene/scene_parts.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

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

std::vector<Contact<3>> by_brute_force(const std::vector<Sphere>& spheres,
                                       const std::vector<Wall<3>>& walls, double eta) {
  std::vector<Contact<3>> found;
  const int count = static_cast<int>(spheres.size());
  for (int i = 0; i < count; ++i) {
    const Sphere& a = spheres[to_size(i)];
    for (int j = i + 1; j < count; ++j) {
      const Vec3 d = a.x - spheres[to_size(j)].x;
      const double gap = d.norm() - a.radius - spheres[to_size(j)].radius;
      if (gap <= eta) found.push_back({i, j, d.normalized(), gap});
    }
    for (std::size_t w = 0; w < walls.size(); ++w) {
      const double gap = walls[w].normal.dot(a.x - walls[w].a) - a.radius;
      if (gap <= eta) found.push_back({i, count + static_cast<int>(w), walls[w].normal, gap});
    }
  }
  return found;
}

// Equal spheres, sizes that fill several levels of the grid, negative coordinates, and coordinates
// far beyond the cells that a key can tell apart: 2^20 cells of 2 m in each direction.
TEST(SphereDetection, FindsWhatBruteForceFinds) {
  const std::vector<Wall<3>> walls = {half_space<3>(Vec3(0, 0, -9), Vec3::UnitZ()),
                                      half_space<3>(Vec3(8, 8, 0), Vec3(-1, -1, 0).normalized())};
  for (const double ratio : {1.0, 3.0, 40.0}) {
    for (const double far : {0.0, 1e7}) {
      const auto spheres = cloud(400, ratio, 20 * std::sqrt(ratio), Vec3(far, -far, far), 7);
      const auto found = detect_contacts<3>(spheres, walls, 0.1);
      const auto expected = by_brute_force(spheres, walls, 0.1);
      ASSERT_GT(expected.size(), 100u);
      ASSERT_EQ(found.size(), expected.size()) << ratio << " at " << far;
      for (std::size_t k = 0; k < found.size(); ++k) {
        EXPECT_EQ(found[k].i, expected[k].i);
        EXPECT_EQ(found[k].j, expected[k].j);
        EXPECT_NEAR(found[k].gap, expected[k].gap, 1e-12 * (20 + far));
        EXPECT_LT((found[k].n - expected[k].n).norm(), 1e-12 * (1 + far));
      }
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

TEST(SphereDetection, CoincidentCentresAreRefused) {
  const std::vector<Sphere> two = {round_body<3>(Vec3(1, 2, 3), 1, 2),
                                   round_body<3>(Vec3(1, 2, 3), 0.5, 2)};
  EXPECT_THROW(detect_contacts<3>(two, {}, 0), std::invalid_argument);
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
