#include "core/scene/sphere_union.h"

#include "core/scene/scene_parts.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

constexpr double kHalfTurn = std::numbers::pi;

Sphere ball(const Vec3& x, double radius) { return round_body<3>(x, radius, 1); }

/// The tensor of inertia at the start, along the axes of space.
Mat<3> tensor(const Cluster<3>& c) {
  const Mat<3> axes = c.axes.toRotationMatrix();
  return axes * c.inertia.asDiagonal() * axes.transpose();
}

// Steiner: Σ V_k (2/5 a_k² + |r_k|² - r_k r_kᵀ).
TEST(SphereUnion, SpheresApartAddUp) {
  const std::vector<Sphere> spheres = {ball(Vec3(1, 0, 0), 0.5), ball(Vec3(0, 2, 0), 1),
                                       ball(Vec3(0, 0, -3), 0.8)};
  const Cluster<3> body = union_of_spheres(spheres);
  double volume = 0;
  Vec3 centre = Vec3::Zero();
  for (const Sphere& s : spheres) {
    const double v = 4 * kHalfTurn / 3 * std::pow(s.radius, 3);
    volume += v;
    centre += v * s.x;
  }
  centre /= volume;
  Mat<3> inertia = Mat<3>::Zero();
  for (const Sphere& s : spheres) {
    const double v = 4 * kHalfTurn / 3 * std::pow(s.radius, 3);
    const Vec3 r = s.x - centre;
    inertia += v * ((0.4 * s.radius * s.radius + r.squaredNorm()) * Mat<3>::Identity() -
                    r * r.transpose());
  }
  EXPECT_NEAR(body.size, volume, 1e-14 * volume);
  EXPECT_LT((body.x - centre).norm(), 1e-14);
  EXPECT_LT((tensor(body) - inertia).norm(), 1e-13 * inertia.norm());
}

// Two spheres of radius a, 2c apart, meet in a lens. Along the line of centres the radius ρ of the
// union has ρ² = a² - (z - c)² for z in [0, c + a], and the same below. With t = z - c from -c to a
//   V = 2π∫(a² - t²),  J_∥ = 2·π/2∫(a² - t²)²,  J_⟂ = J_∥/2 + 2π∫(a² - t²)(t + c)².
TEST(SphereUnion, ALensCountsOnce) {
  for (const Vec3& along : {Vec3(0, 0, 1), Vec3(2, -1, 2)}) {
    constexpr double a = 0.7, c = 0.4;
    const Vec3 axis = along.normalized();
    const Vec3 middle(5, -3, 2);
    const std::vector<Sphere> spheres = {ball(middle + c * axis, a), ball(middle - c * axis, a)};
    const auto from_to = [&](const auto& f) { return f(a) - f(-c); };
    const double volume =
        2 * kHalfTurn * from_to([&](double t) { return a * a * t - std::pow(t, 3) / 3; });
    const double about =
        kHalfTurn * from_to([&](double t) {
          return std::pow(a, 4) * t - 2 * a * a * std::pow(t, 3) / 3 + std::pow(t, 5) / 5;
        });
    // (a² - t²)(t + c)² = a²t² + 2a²ct + a²c² - t⁴ - 2ct³ - c²t².
    const double across = about / 2 + 2 * kHalfTurn * from_to([&](double t) {
                                        return (a * a - c * c) * std::pow(t, 3) / 3 +
                                               a * a * c * t * t + a * a * c * c * t -
                                               std::pow(t, 5) / 5 - c * std::pow(t, 4) / 2;
                                      });
    const Cluster<3> body = union_of_spheres(spheres);
    EXPECT_NEAR(body.size, volume, 1e-9 * volume);
    EXPECT_LT((body.x - middle).norm(), 1e-9);
    const Mat<3> expected =
        across * Mat<3>::Identity() + (about - across) * axis * axis.transpose();
    EXPECT_LT((tensor(body) - expected).norm(), 1e-8 * across);
    // A box that ends in the middle holds one half.
    if (along[0] == 0) {
      const Vec3 low(-kInfinity, -kInfinity, -kInfinity), high(kInfinity, kInfinity, middle[2]);
      EXPECT_NEAR(union_volume_in(spheres, low, high), volume / 2, 1e-8);
      EXPECT_NEAR(union_volume_in(spheres, low, Vec3::Constant(kInfinity)), volume, 1e-8);
      EXPECT_NEAR(union_volume_in(spheres, low, Vec3(middle[0], kInfinity, kInfinity)), volume / 2,
                  1e-4 * volume);
    }
  }
}

TEST(SphereUnion, ASphereWithinAnotherAddsNothing) {
  const Cluster<3> body =
      union_of_spheres(std::vector{ball(Vec3(1, 2, 3), 1), ball(Vec3(1.3, 2, 3), 0.5)});
  EXPECT_NEAR(body.size, 4 * kHalfTurn / 3, 1e-9);
  EXPECT_LT((body.x - Vec3(1, 2, 3)).norm(), 1e-9);
  EXPECT_LT((body.inertia - Vec3::Constant(1.6 * kHalfTurn / 3)).norm(), 1e-8);
}

}  // namespace
}  // namespace bipot
