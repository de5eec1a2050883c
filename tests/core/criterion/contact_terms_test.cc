#include "core/criterion/contact_terms.h"

#include <gtest/gtest.h>

#include <random>

#include "core/criterion/rounded.h"

namespace bipot {
namespace {

template <class Real, int D>
FrameVector<Real, D> as(const FrameVector<double, D>& x) {
  FrameVector<Real, D> y;
  each_component<D>([&](int k) { y[k] = Real(x[k]); });
  return y;
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
  const auto on_cone = physical_projection(true, as<Real>(s), as<Real>(r), Real(mu));
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
  const Real w_nn = positive(random), rho_nn = 1 / w_nn, arm = positive(random);
  const RollingFriction<double> given{positive(random), positive(random), positive(random)};
  const auto friction = over_arm(as_number<Real>(given), arm);
  const auto on_cone =
      physical_projection(true, times_arm<K>(as<Real>(s), Real(1 / arm)), as<Real>(r), friction);
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

}  // namespace
}  // namespace bipot
