#include "solvers/kernels/contact_penalties.h"

#include "core/problem/coulomb_cone.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// The penalties after z was seen often enough that all metrics are at their ends.
template <int D>
ContactPenalties<D> settled(const Vector& mu, const Vector& z, Vector& y, double rho = 0.1) {
  ContactPenalties<D> penalties({mu.begin(), mu.end()}, rho);
  // The first change finds that everything has changed: nothing was known.
  for (int k = 0; k < 8; ++k) {
    penalties.observe(z);
    penalties.adapt(y);
  }
  return penalties;
}

TEST(ContactPenalties, FollowWhatAContactGoesOnDoing) {
  // Take-off, stick, near the edge, slip one way and the other, mu = 0.5.
  const Vector mu = Vector::Constant(5, 0.5);
  Vector z(10), y(10);
  z << 0, 0, 2, 0.1, 2, 0.9, 2, 1, 2, -1;
  for (int i = 0; i < 10; ++i) y[i] = 0.3 * i - 1;
  ContactPenalties<2> fresh({mu.begin(), mu.end()}, 0.1);
  Vector push(10);
  for (int c = 0; c < 5; ++c) {
    push.segment<2>(2 * c) = fresh.times(c, y.segment<2>(2 * c));
    EXPECT_EQ(fresh.metric(c), 0.1 * Eigen::Matrix2d::Identity());
  }
  const ContactPenalties<2> penalties = settled<2>(mu, z, y);
  const auto metric = [&](int c) { return Eigen::Matrix2d(penalties.metric(c)); };
  EXPECT_TRUE(metric(0).isApprox(10 * Eigen::Matrix2d::Identity()));     // 100 rho
  EXPECT_TRUE(metric(1).isApprox(0.001 * Eigen::Matrix2d::Identity()));  // rho / 100
  EXPECT_TRUE(metric(2).isApprox(0.1 * Eigen::Matrix2d::Identity()));    // rho
  for (int c : {3, 4}) {
    const double side = c == 3 ? 1 : -1;
    const Eigen::Vector2d along(1, 0.5 * side), across(-0.5 * side, 1);
    EXPECT_TRUE((metric(c) * along).isApprox(0.1 * along));   // rho
    EXPECT_TRUE((metric(c) * across).isApprox(10 * across));  // 100 rho
  }
  for (int c = 0; c < 5; ++c) {
    EXPECT_TRUE((metric(c) * penalties.inverse(c)).isApprox(Eigen::Matrix2d::Identity(), 1e-14));
    // The velocity that the multiplier stands for is what it was.
    EXPECT_TRUE((metric(c) * y.segment<2>(2 * c)).isApprox(push.segment<2>(2 * c), 1e-13)) << c;
  }
}

TEST(ContactPenalties, AChangeOfStatusOrEqualiseStartsAgain) {
  const Vector mu = Vector::Constant(1, 0.5);
  Vector stick(2), slip(2), y = Vector::Ones(2);
  stick << 1, 0;
  slip << 1, 0.5;
  ContactPenalties<2> penalties = settled<2>(mu, stick, y);
  EXPECT_LT(penalties.metric(0)(0, 0), 0.002);
  penalties.observe(slip);
  penalties.observe(stick);  // between two changes it was elsewhere
  penalties.adapt(y);
  EXPECT_TRUE(penalties.metric(0).isApprox(0.1 * Eigen::Matrix2d::Identity()));
  penalties = settled<2>(mu, slip, y);
  penalties.scale(3);
  const Eigen::Vector2d push = penalties.times(0, y);
  penalties.equalise(y);
  EXPECT_TRUE(penalties.metric(0).isApprox(0.3 * Eigen::Matrix2d::Identity()));
  EXPECT_TRUE(penalties.times(0, y).isApprox(push, 1e-14));
}

/// z is the nearest point of the cone in the metric M if and only if z is in the cone, M (r - z) in
/// the polar cone, and both are orthogonal.
TEST(ContactPenalties, ProjectInTheirMetric) {
  const Vector mu = Vector::Constant(2, 0.4);
  Vector z(4), y = Vector::Zero(4);
  z << 1, 0.4, 1, -0.4;
  const ContactPenalties<2> penalties = settled<2>(mu, z, y, 1);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> draw(-1, 1);
  int inside = 0, zero = 0, edge = 0;
  for (int k = 0; k < 3000; ++k) {
    const int c = k % 2;
    const Local<2> r(draw(random), draw(random)), p = penalties.project(c, r);
    const Local<2> left = penalties.times(c, Local<2>(r - p));
    EXPECT_LE(std::abs(p[1]), 0.4 * p[0] * (1 + 1e-15) + 1e-16);
    for (const double side : {-0.4, 0.4}) {
      EXPECT_LE(left.dot(Local<2>(1, side)), 1e-12) << r.transpose();
    }
    EXPECT_NEAR(left.dot(p), 0, 1e-12);
    ++(p == r ? inside : p.isZero(0) ? zero : edge);
  }
  EXPECT_GT(std::min({inside, zero, edge}), 100);
}

/// In space the edge e, the normal of the cone n and their third direction have factors of their
/// own: 1, 100 and its root.
TEST(ContactPenalties, FollowTheEdgeInSpace) {
  Vector y = Vector::Ones(9), z(9);
  z << 1, 0.3, 0.4, 1, 0, 0, 1, 0.297, 0.396;  // on the edge for mu = 0.5; two that stick
  const auto space = settled<3>(Vector::Constant(3, 0.5), z, y);
  const Eigen::Vector3d edge(1, 0.3, 0.4), normal(-0.5, 0.6, 0.8), around(0, -0.8, 0.6);
  EXPECT_TRUE((space.metric(0) * edge).isApprox(0.1 * edge));
  EXPECT_TRUE((space.metric(0) * normal).isApprox(10 * normal));
  EXPECT_TRUE((space.metric(0) * around).isApprox(around));
  EXPECT_TRUE((space.metric(0) * space.inverse(0)).isApprox(Eigen::Matrix3d::Identity(), 1e-13));
  EXPECT_TRUE(space.metric(1).isApprox(0.001 * Eigen::Matrix3d::Identity()));
  EXPECT_TRUE(space.metric(2).isApprox(0.1 * Eigen::Matrix3d::Identity()));  // near the edge
  const Local<3> r(0.2, 1, -1);
  EXPECT_EQ(space.project(1, r), project_coulomb_cone<3>(r, 0.5));
}

/// As for the plane; the largest product of M (r - z) with the rays of the cone is at the ray in
/// the direction of its tangential part.
TEST(ContactPenalties, ProjectOnTheRoundCone) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> draw(-1, 1);
  int inside = 0, zero = 0, edge = 0;
  for (const double mu : {0.1, 0.4, 2.0}) {
    Vector z(3), y = Vector::Zero(3);
    z << 1, 0.6 * mu, -0.8 * mu;
    const ContactPenalties<3> penalties = settled<3>(Vector::Constant(1, mu), z, y, 1);
    for (int k = 0; k < 3000; ++k) {
      const Local<3> r(draw(random), draw(random), draw(random)), p = penalties.project(0, r);
      const Local<3> left = penalties.times(0, Local<3>(r - p));
      EXPECT_LE(tangential_norm<3>(p), mu * p[0] * (1 + 1e-14) + 1e-16);
      EXPECT_LE(left[0] + mu * tangential_norm<3>(left), 1e-10) << r.transpose();
      EXPECT_NEAR(left.dot(p), 0, 1e-10);
      ++(p == r ? inside : p.isZero(0) ? zero : edge);
    }
  }
  EXPECT_GT(std::min({inside, zero, edge}), 100);
}

TEST(ContactPenalties, WithoutFrictionMetricsAreMultiplesOfTheIdentity) {
  Vector y = Vector::Ones(2), z(2);
  z << 1, 0;
  const auto smooth = settled<1>(Vector::Zero(2), z, y);
  EXPECT_NEAR(smooth.metric(0)(0, 0), 0.001, 1e-15);
  EXPECT_NEAR(smooth.metric(1)(0, 0), 10, 1e-12);
}

}  // namespace
}  // namespace bipot
