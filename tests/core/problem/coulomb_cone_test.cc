#include "core/problem/coulomb_cone.h"

#include "core/base/portable_random.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

template <int D>
Local<D> random_local(PortableRandom& draw) {
  Local<D> x;
  for (int k = 0; k < D; ++k) x[k] = 3 * draw.symmetric();
  return x;
}

template <int D>
Local<D> random_in_cone(PortableRandom& draw, double mu) {
  Local<D> s = random_local<D>(draw);
  s[0] = std::abs(s[0]);
  const double length = tangential_norm<D>(s);
  if constexpr (D > 1) s.template tail<D - 1>() *= draw.uniform() * mu * s[0] / length;
  return s;
}

/// Squared distance of tau from the slice s_n = x of the cone: tau's tangential part against a
/// ball of radius mu x. Convex in x.
template <int D>
double slice_distance(const Local<D>& tau, double mu, double x) {
  const double excess = std::max(tangential_norm<D>(tau) - mu * x, 0.0);
  return (tau[0] - x) * (tau[0] - x) + excess * excess;
}

/// Golden section over the normal component, nothing of (34).
template <int D>
double brute_force_normal(const Local<D>& tau, double mu) {
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  double low = 0, high = (1 + mu) * tau.norm() + 1;
  for (int k = 0; k < 200; ++k) {
    const double a = high - ratio * (high - low), b = low + ratio * (high - low);
    if (slice_distance<D>(tau, mu, a) <= slice_distance<D>(tau, mu, b)) {
      high = b;
    } else {
      low = a;
    }
  }
  return 0.5 * (low + high);
}

template <class Dimension>
class CoulombCone : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 1>, std::integral_constant<int, 2>,
                                  std::integral_constant<int, 3>>;
class DimensionNames {
 public:
  template <class T>
  static std::string GetName(int) {
    return "d" + std::to_string(T::value);
  }
};
TYPED_TEST_SUITE(CoulombCone, Dimensions, DimensionNames);

TYPED_TEST(CoulombCone, ProjectionIsTheNearestPoint) {
  constexpr int D = TypeParam::value;
  PortableRandom draw(1);
  for (int trial = 0; trial < 1000; ++trial) {
    const double mu = trial % 10 == 0 ? 0.0 : draw.decades(-2, 0.7);
    const Local<D> tau = random_local<D>(draw);
    const Local<D> p = project_coulomb_cone<D>(tau, mu);
    ASSERT_LE(tangential_norm<D>(p), mu * p[0] * (1 + 1e-15) + 1e-300);
    const double best = brute_force_normal<D>(tau, D == 1 ? 0.0 : mu);
    // The minimiser of a smooth function is found to the root of the machine precision.
    EXPECT_NEAR(p[0], best, 1e-6);
    EXPECT_LE((tau - p).squaredNorm(),
              slice_distance<D>(tau, D == 1 ? 0.0 : mu, best) * (1 + 1e-12) + 1e-14);
    for (int k = 0; k < 20; ++k) {
      const Local<D> s = random_in_cone<D>(draw, mu);
      EXPECT_LE((tau - p).norm(), (tau - s).norm() * (1 + 1e-14));
      // The variational inequality (tau - p)·(s - p) <= 0.
      EXPECT_LE((tau - p).dot(s - p), 1e-14 * (1 + tau.squaredNorm() + s.squaredNorm()));
    }
  }
}

TYPED_TEST(CoulombCone, ProjectionIsIdempotentAndNonexpansive) {
  constexpr int D = TypeParam::value;
  PortableRandom draw(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const double mu = trial % 10 == 0 ? 0.0 : draw.decades(-2, 0.7);
    const Local<D> a = random_local<D>(draw), b = random_local<D>(draw);
    const Local<D> pa = project_coulomb_cone<D>(a, mu), pb = project_coulomb_cone<D>(b, mu);
    EXPECT_LE((project_coulomb_cone<D>(pa, mu) - pa).norm(), 4e-16 * pa.norm());
    EXPECT_LE((pa - pb).norm(), (a - b).norm() * (1 + 1e-14));
  }
}

TYPED_TEST(CoulombCone, NotANumberStaysNotANumber) {
  constexpr int D = TypeParam::value;
  for (int k = 0; k < D; ++k) {
    Local<D> tau = Local<D>::Ones();
    tau[k] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(project_coulomb_cone<D>(tau, 0.5).allFinite());
  }
}

TEST(CoulombConeCases, PolarConeGoesToTheApex) {
  // mu |tau_t| <= -tau_n, edge of the polar cone included.
  EXPECT_EQ(project_coulomb_cone<2>({-1.0, 1.5}, 0.5), Local<2>(0, 0));
  EXPECT_EQ(project_coulomb_cone<2>({-1.0, -2.0}, 0.5), Local<2>(0, 0));
  EXPECT_EQ(project_coulomb_cone<3>({-2.5, 3.0, 4.0}, 0.5), Local<3>(0, 0, 0));
  EXPECT_EQ(project_coulomb_cone<2>({0.0, 0.0}, 0.5), Local<2>(0, 0));
}

TEST(CoulombConeCases, ConeAndItsEdgeStay) {
  EXPECT_EQ(project_coulomb_cone<2>({2.0, -0.5}, 0.5), Local<2>(2, -0.5));
  EXPECT_EQ(project_coulomb_cone<2>({2.0, 1.0}, 0.5), Local<2>(2, 1));
  EXPECT_EQ(project_coulomb_cone<3>({10.0, 3.0, 4.0}, 0.5), Local<3>(10, 3, 4));
}

TEST(CoulombConeCases, BetweenThemGoesToTheEdge) {
  // tau = (1, 3), mu = 0.5: s_n = (1 + 1.5) / 1.25 = 2, s_t = 1.
  EXPECT_TRUE(project_coulomb_cone<2>({1.0, 3.0}, 0.5).isApprox(Local<2>(2, 1), 1e-15));
  // The same radius along (3, 4)/5.
  EXPECT_TRUE(project_coulomb_cone<3>({1.0, 1.8, 2.4}, 0.5).isApprox(Local<3>(2, 0.6, 0.8), 1e-15));
}

TEST(CoulombConeCases, WithoutFrictionOnlyTheNormalPartIsLeft) {
  EXPECT_EQ(project_coulomb_cone<2>({2.0, 7.0}, 0), Local<2>(2, 0));
  EXPECT_EQ(project_coulomb_cone<2>({-2.0, 7.0}, 0), Local<2>(0, 0));
  EXPECT_EQ(project_coulomb_cone<3>({2.0, 7.0, 1.0}, 0), Local<3>(2, 0, 0));
  EXPECT_EQ(project_coulomb_cone<1>(Local<1>(2.0), 0.3), Local<1>(2));
  EXPECT_EQ(project_coulomb_cone<1>(Local<1>(-2.0), 0.3), Local<1>(0));
}

TEST(CoulombConeCases, ModifiedVelocityLiesInTheDualConeWhenNothingPenetrates) {
  // û·s >= 0 for every s in the cone.
  PortableRandom draw(3);
  for (int trial = 0; trial < 1000; ++trial) {
    Local<3> u = random_local<3>(draw);
    u[0] = std::abs(u[0]);
    const double mu = draw.uniform();
    EXPECT_GE(de_saxce_velocity<3>(u, mu).dot(random_in_cone<3>(draw, mu)), -1e-14);
  }
  EXPECT_EQ(de_saxce_velocity<2>({1.0, -2.0}, 0.5), Local<2>(2, -2));
  EXPECT_EQ(de_saxce_velocity<1>(Local<1>(1.0), 0.5), Local<1>(1));
}

// Rolling friction: |s_t| <= mu s_n, |m| <= mu_r s_n, |m_spin| <= mu_spin s_n.

/// Squared distance of tau from the slice s_n = x of the cone; convex in x.
template <int D>
double rolling_slice_distance(const Local<D>& tau, const RollingFriction<double>& f, double x) {
  const bool space = D == 6;
  const double parts[3] = {space ? std::hypot(tau[1], tau[2]) : std::abs(tau[1]),
                           space ? std::hypot(tau[3], tau[4]) : std::abs(tau[2]),
                           space ? std::abs(tau[5]) : 0.0};
  const double bounds[3] = {f.slide, f.roll, f.spin};
  double sum = (tau[0] - x) * (tau[0] - x);
  for (int k = 0; k < 3; ++k) sum += std::pow(std::max(parts[k] - bounds[k] * x, 0.0), 2);
  return sum;
}

/// The set of parts of s that are on their bounds, as bits; -1 at the apex.
template <int D>
int region_of(const Local<D>& tau, const Local<D>& s, const RollingFriction<double>& f) {
  if (s[0] == 0) return -1;
  int region = 0, bit = 1;
  each_bounded<D>(f, [&](auto first, auto count, double bound) {
    if (part_norm<first(), count()>(tau) > bound * s[0]) region |= bit;
    bit *= 2;
  });
  return region;
}

template <int D>
void project_on_rolling_cones(int regions) {
  PortableRandom draw(5);
  std::set<int> seen;
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  for (int trial = 0; trial < 3000; ++trial) {
    RollingFriction<double> f{draw.decades(-2, 0.7), draw.decades(-2, 0.7), draw.decades(-2, 0.7)};
    if (trial % 10 == 0) f.slide = 0;
    if (trial % 10 == 1) f.roll = 0;
    if (trial % 10 == 2) f.spin = 0;
    const Local<D> tau = random_local<D>(draw);
    const Local<D> s = project_coulomb_cone<D>(tau, f);
    seen.insert(region_of<D>(tau, s, f));
    each_bounded<D>(f, [&](auto first, auto count, double bound) {
      EXPECT_LE((part_norm<first(), count()>(s)), bound * s[0] * (1 + 4e-16) + 1e-300);
    });
    double low = 0, high = (1 + f.slide + f.roll + f.spin) * tau.norm() + 1;
    for (int k = 0; k < 200; ++k) {
      const double a = high - ratio * (high - low), b = low + ratio * (high - low);
      const bool left =
          rolling_slice_distance<D>(tau, f, a) <= rolling_slice_distance<D>(tau, f, b);
      (left ? high : low) = left ? b : a;
    }
    EXPECT_NEAR(s[0], 0.5 * (low + high), 1e-6);
    EXPECT_LE((tau - s).squaredNorm(),
              rolling_slice_distance<D>(tau, f, 0.5 * (low + high)) * (1 + 1e-12) + 1e-14);
    // The projection is exact: idempotent, and tau - s is across s and in the polar cone.
    EXPECT_LE((project_coulomb_cone<D>(s, f) - s).norm(), 1e-15 * s.norm());
    EXPECT_NEAR((tau - s).dot(s), 0, 1e-13 * (1 + tau.squaredNorm()));
    EXPECT_LE((tau - s)[0] + friction_speed<D>(Local<D>(tau - s), f), 1e-14 * (1 + tau.norm()));
    // û of a velocity that does not penetrate is in the dual cone.
    Local<D> u = random_local<D>(draw);
    u[0] = std::abs(u[0]);
    EXPECT_GE(de_saxce_velocity<D>(u, f).dot(s), -1e-13 * (1 + tau.norm()));
  }
  EXPECT_EQ(seen.size(), static_cast<std::size_t>(regions)) << "apex, inside, every set of bounds";
}

TEST(RollingCone, ProjectionIsTheNearestPointInEveryRegionOfThePlane) {
  project_on_rolling_cones<3>(5);
}
TEST(RollingCone, ProjectionIsTheNearestPointInEveryRegionOfSpace) {
  project_on_rolling_cones<6>(9);
}

// tau = (1, 3, 5), mu = mu_r = 1. Both bounds: s_n = (1 + 3 + 5)/3 = 3; then |tau_t| = 3 is inside
// and counts no more: s_n = (1 + 5)/2 = 3, s = (3, 3, 3).
TEST(RollingCone, APartInsideItsBoundDoesNotPush) {
  const RollingFriction<double> one{1, 1, 0};
  EXPECT_TRUE(project_coulomb_cone<3>({1.0, 3.0, 5.0}, one).isApprox(Local<3>(3, 3, 3), 1e-15));
  EXPECT_TRUE(project_coulomb_cone<3>({1.0, 2.0, 5.0}, one).isApprox(Local<3>(3, 2, 3), 1e-15));
  EXPECT_EQ(project_coulomb_cone<3>({-8.0, 3.0, 5.0}, one), Local<3>(0, 0, 0)) << "polar edge";
  EXPECT_EQ(project_coulomb_cone<3>({5.0, 3.0, 5.0}, one), Local<3>(5, 3, 5)) << "edge";
}

}  // namespace
}  // namespace bipot
