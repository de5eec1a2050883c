#include "core/criterion/contact_terms.h"

#include <type_traits>

#include "core/criterion/rounded.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

template <class Real, int D>
FrameVector<Real, D> as(const FrameVector<double, D>& x) {
  FrameVector<Real, D> y;
  each_component<D>([&](int k) { y[k] = Real(x[k]); });
  return y;
}

/// The projection in wider precision is that in double, to the rounding of the latter.
template <class Real, int D, class Friction>
void expect_projects(const FrameVector<double, D>& s, const FrameVector<double, D>& r,
                     const Friction& friction, const FrameVector<double, D>& projected) {
  if constexpr (!std::is_same_v<Real, Rounded>) {  // which judges given impulses alone
    const auto wide = physical_projection(true, as<Real>(s), as<Real>(r), friction);
    for (int k = 0; k < D; ++k) EXPECT_NEAR(static_cast<double>(wide[k]), projected[k], 1e-13);
  }
}

template <class Real, class Contact>
std::vector<Real> sums_of(const Contact& contact, Real rho_nn, Real b_n) {
  ErrorSumsOf<Real> e;
  add_law_terms(contact, law_terms(contact), e);
  add_reported_terms(contact, law_terms(contact), Real(0.3), e);
  e.free_energy += approach_energy(rho_nn, b_n);
  return {e.friction, e.gap,         e.gap_clipped, e.penetration, e.moved,
          e.impulse2, e.natural_rel, e.free_energy, e.natural};
}

/// Terms of a scaled contact with any numbers: s drawn, projected on the cone in physical
/// variables.
template <class Real, int D>
std::vector<Real> terms_of(unsigned seed, double mu) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1), positive(0.1, 2);
  FrameVector<double, D> s, u, b, r;
  for (auto* x : {&s, &u, &b}) each_component<D>([&](int k) { (*x)[k] = any(random); });
  r[0] = positive(random);
  for (int k = 1; k < D; ++k) r[k] = k == 1 ? positive(random) : r[1];
  const Real w_nn = positive(random), rho_nn = 1 / w_nn;
  const FrameVector<double, D> projected = physical_projection(true, s, r, mu);
  expect_projects<Real>(s, r, Real(mu), projected);
  const auto on_cone = as<Real>(projected);
  const auto contact = physical_contact(true, on_cone, as<Real>(u), as<Real>(b), as<Real>(r),
                                        Real(mu), w_nn, rho_nn);
  return sums_of(contact, rho_nn, Real(b[0]));
}

/// The same with rolling friction and an arm.
template <class Real, ContactRows K>
std::vector<Real> rolling_terms_of(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1, 1), positive(0.1, 2);
  FrameVector<double, K> s, u, b, r;
  for (auto* x : {&s, &u, &b}) each_component<K>([&](int k) { (*x)[k] = any(random); });
  r[0] = positive(random);
  for (int k = 1; k < K; ++k) r[k] = 1.25;
  const Real w_nn = positive(random), rho_nn = 1 / w_nn;
  const double length = positive(random);
  const Real arm = length;
  const RollingFriction<double> given{positive(random), positive(random), positive(random)};
  const auto friction = over_arm(as_number<Real>(given), arm);
  const FrameVector<double, K> over = times_arm<K>(s, 1 / length);
  const FrameVector<double, K> projected =
      physical_projection(true, over, r, over_arm(given, length));
  expect_projects<Real>(over, r, friction, projected);
  const auto on_cone = as<Real>(projected);
  const auto contact =
      physical_contact(true, on_cone, times_arm<K>(as<Real>(u), arm),
                       times_arm<K>(as<Real>(b), arm), as<Real>(r), friction, w_nn, rho_nn);
  return sums_of(contact, rho_nn, Real(b[0]));
}

/// Sums of doubles differ from exact ones by the bound of their rounding, itself at most `largest`,
/// those of extended precision by a thousandth of it. `terms` takes any number of a type.
template <class Terms>
void expect_bounds_to_hold(const Terms& terms, double largest) {
  const std::vector<Quadruple> exact = terms(Quadruple());
  const std::vector<long double> extended = terms(0.0L);
  const std::vector<double> computed = terms(0.0);
  const std::vector<Rounded> rounded = terms(Rounded());
  for (std::size_t k = 0; k < exact.size(); ++k) {
    EXPECT_EQ(rounded[k].value, computed[k]) << "the same formulas, sum " << k;
    double error = rounded[k].error;
    // Its error is the square of a norm's, which is to be added to the norm.
    if (k + 1 == exact.size()) error += 2 * std::sqrt(error * rounded[k].value);
    EXPECT_LE(static_cast<double>(absolute<Quadruple>(computed[k] - exact[k])), error) << k;
    EXPECT_LE(rounded[k].error, largest) << k;
    EXPECT_LE(static_cast<double>(absolute<Quadruple>(extended[k] - exact[k])), error / 1000) << k;
  }
}

template <int D>
void expect_plain_bounds_to_hold() {
  for (const double mu : {0.0, 0.4, 30.0}) {
    for (unsigned seed = 1; seed <= 300; ++seed) {
      SCOPED_TRACE(testing::Message() << "d = " << D << ", mu = " << mu << ", seed " << seed);
      expect_bounds_to_hold([&]<class Real>(Real) { return terms_of<Real, D>(seed, mu); },
                            1e-11 * (1 + mu * mu));
    }
  }
}

// The same formulas for all number types: they differ by rounding alone, within its bound.
TEST(ContactTerms, NumberTypesDifferByTheirRounding) {
  expect_plain_bounds_to_hold<1>();
  expect_plain_bounds_to_hold<2>();
  expect_plain_bounds_to_hold<3>();
}

template <ContactRows K>
void expect_rolling_bounds_to_hold() {
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    SCOPED_TRACE(testing::Message() << "rows " << int{K} << ", seed " << seed);
    expect_bounds_to_hold([&]<class Real>(Real) { return rolling_terms_of<Real, K>(seed); }, 1e-10);
  }
}

TEST(ContactTerms, RollingDiffersByItsRounding) {
  expect_rolling_bounds_to_hold<ContactRows(3, true)>();
  expect_rolling_bounds_to_hold<ContactRows(6, true)>();
}

// s = 0 and u_n >= 0 is the law exactly. Within the error of u_n the natural map is bounded
// instead.
TEST(ContactTerms, ARoundedContactTakesOffWhereThatIsCertain) {
  PhysicalContact<Rounded, 2> c{{}, {}, 0, 0.5, 2, 0.5, 0};
  c.u[0] = {1e-3, 1e-4};
  EXPECT_TRUE(takes_off(c));
  c.u[0] = {1e-5, 1e-4};
  EXPECT_FALSE(takes_off(c));
  ErrorSumsOf<Rounded> sums;
  add_law_terms(c, law_terms(c), sums);
  EXPECT_EQ(sums.natural.value, 0);
  EXPECT_GT(sums.natural.error, 0);
  c.s[0] = {1e-3, 1e-6};
  EXPECT_FALSE(takes_off(c));
}

/// A contact slides with the velocity 1 and approaches with d. For s = 0 the point is
/// rho d / (1 + mu²) (1, -mu), hence |N| = rho d / sqrt(1 + mu²). For s = rho d (1, -mu) it is s and
/// the same once more. Once the approach has stopped, u_n = 0, this s is the law.
template <class Real, int D>
void expect_exact_for_slow_approach() {
  const double mu = 0.3, rho = 0.7;
  for (const double d : {1e-3, 1e-12, 1e-20, 1e-40, 1e-80}) {
    PhysicalContact<Real, D> c{{}, {}, Real(1), Real(mu), Real(1 / rho), Real(rho), Real{}};
    c.u[0] = -d;
    c.u[D - 1] = 1;
    const auto length = [&] {
      const FrameVector<Real, D> N = natural_map(c, c.rho_nn);
      return static_cast<double>(root<Real>(dot(N, N) / Real(d) / Real(d)));
    };
    EXPECT_NEAR(length(), rho / std::sqrt(1 + mu * mu), 1e-14) << d;
    c.s[0] = rho * d;
    c.s[D - 1] = -mu * rho * d;
    EXPECT_NEAR(length(), rho / std::sqrt(1 + mu * mu), 1e-14) << d;
    c.u[0] = 0;
    EXPECT_NEAR(length(), 0, 1e-15) << d;
  }
}

// Where rho |u_t| is beyond all digits of s_n, their difference would be rounding alone.
TEST(ContactTerms, TheNaturalMapOfASlowApproachIsExact) {
  expect_exact_for_slow_approach<double, 2>();
  expect_exact_for_slow_approach<double, 3>();
  expect_exact_for_slow_approach<long double, 3>();
  expect_exact_for_slow_approach<Quadruple, 2>();
}

/// A contact slides with the velocity 1, rolls with 2, spins and approaches with d: for s = 0 the
/// point is rho d / (1 + Σ mu_g²) (1, -mu_g, ..), and |N| = rho d / sqrt(1 + Σ mu_g²), where a part
/// that does not move has no share.
template <ContactRows K>
void expect_exact_for_slow_rolling(const RollingFriction<double>& friction, double spin) {
  const double rho = 0.7;
  double sum = 1 + friction.slide * friction.slide + friction.roll * friction.roll;
  if (spin != 0) sum += friction.spin * friction.spin;
  for (const double d : {1e-3, 1e-20, 1e-60}) {
    PhysicalContact<double, K, RollingFriction<double>> c{{}, {}, 0, friction, 1 / rho, rho, 0};
    c.u[0] = -d;
    c.u[1] = 1;
    c.u[1 + K.tangents()] = -2;
    if constexpr (K == 6) c.u[5] = spin;
    c.slip = friction_speed<K>(c.u, friction);
    const auto N = natural_map(c, rho);
    EXPECT_NEAR(std::sqrt(dot(N, N)) / d, rho / std::sqrt(sum), 1e-14) << d;
  }
}

TEST(ContactTerms, TheNaturalMapOfASlowRollingApproachIsExact) {
  expect_exact_for_slow_rolling<ContactRows(3, true)>({0.3, 0.1, 0}, 0);
  expect_exact_for_slow_rolling<ContactRows(6, true)>({0.3, 0.1, 0.2}, 3);
  expect_exact_for_slow_rolling<ContactRows(6, true)>({0.3, 0.1, 0.2}, 0);
}

}  // namespace
}  // namespace bipot
