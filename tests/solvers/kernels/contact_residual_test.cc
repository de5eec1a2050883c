#include "solvers/kernels/contact_residual.h"

#include "core/base/portable_random.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

template <int D>
using Function = LocalResidual<D> (*)(const Local<D>&, const Local<D>&, double);

/// Central differences at points drawn away from the edges, where the functions are smooth.
template <int D>
void expect_jacobian_matches(Function<D> f, double mu) {
  PortableRandom random(3);
  constexpr double kStep = 1e-6;
  for (int trial = 0; trial < 200; ++trial) {
    Local<D> s, u;
    for (int k = 0; k < D; ++k) {
      s[k] = random.symmetric();
      u[k] = random.symmetric();
    }
    const LocalResidual<D> r = f(s, u, mu);
    for (int k = 0; k < D; ++k) {
      const Local<D> e = kStep * Local<D>::Unit(k);
      const Local<D> in_s = (f(s + e, u, mu).f - f(s - e, u, mu).f) / (2 * kStep);
      const Local<D> in_u = (f(s, u + e, mu).f - f(s, u - e, mu).f) / (2 * kStep);
      EXPECT_LT((r.P.col(k) - in_s).norm(), 1e-5) << "trial " << trial << " column " << k;
      EXPECT_LT((r.Q.col(k) - in_u).norm(), 1e-5) << "trial " << trial << " column " << k;
    }
  }
}

/// Pairs on Coulomb's law: take-off, stick, slip.
template <int D>
std::vector<std::pair<Local<D>, Local<D>>> pairs_on_the_law(double mu) {
  Local<D> direction = Local<D>::Zero();
  if constexpr (D == 2) direction[1] = -1;
  if constexpr (D == 3) direction << 0, 0.6, -0.8;
  const Local<D> normal = Local<D>::Unit(0);
  const Local<D> zero = Local<D>::Zero();
  return {{zero, 0.7 * normal + 0.3 * direction},
          {1.3 * normal + 0.5 * mu * direction, zero},
          {1.3 * normal - 1.3 * mu * direction, 0.4 * direction}};
}

template <int D>
void expect_zero_on_the_law_only(Function<D> f, double mu) {
  for (const auto& [s, u] : pairs_on_the_law<D>(mu)) {
    EXPECT_LT(f(s, u, mu).f.norm(), 1e-14);
    EXPECT_GT(f(s + 0.1 * Local<D>::Unit(0), u + 0.1 * Local<D>::Unit(0), mu).f.norm(), 1e-3);
    EXPECT_GT(f(s, u - Local<D>::Unit(0), mu).f.norm(), 1e-3) << "penetration";
    if constexpr (D > 1) {
      if (s[0] > 0) {
        Local<D> tangential = s;
        tangential[0] = 0;
        EXPECT_GT(f(s, tangential, mu).f.norm(), 1e-3) << "slip along the impulse";
        EXPECT_GT(f(s + 2 * tangential, u, mu).f.norm(), 1e-3) << "outside the cone";
      }
    }
  }
}

TEST(AlartCurnier, VanishesOnTheLawOnly) {
  expect_zero_on_the_law_only<1>(&alart_curnier<1>, 0);
  expect_zero_on_the_law_only<2>(&alart_curnier<2>, 0.4);
  expect_zero_on_the_law_only<3>(&alart_curnier<3>, 0.4);
}

TEST(AlartCurnier, JacobianMatchesDifferences) {
  expect_jacobian_matches<1>(&alart_curnier<1>, 0);
  expect_jacobian_matches<2>(&alart_curnier<2>, 0.4);
  expect_jacobian_matches<3>(&alart_curnier<3>, 0.4);
  expect_jacobian_matches<3>(&alart_curnier<3>, 0);
}

TEST(FischerBurmeister, VanishesOnTheLawOnly) {
  expect_zero_on_the_law_only<1>(&fischer_burmeister<1>, 0);
  expect_zero_on_the_law_only<2>(&fischer_burmeister<2>, 0.4);
  expect_zero_on_the_law_only<3>(&fischer_burmeister<3>, 0.4);
  expect_zero_on_the_law_only<3>(&fischer_burmeister<3>, 1.7);
}

TEST(FischerBurmeister, JacobianMatchesDifferences) {
  expect_jacobian_matches<1>(&fischer_burmeister<1>, 0);
  expect_jacobian_matches<2>(&fischer_burmeister<2>, 0.4);
  expect_jacobian_matches<3>(&fischer_burmeister<3>, 0.4);
  expect_jacobian_matches<3>(&fischer_burmeister<3>, 1.7);
  expect_jacobian_matches<3>(&fischer_burmeister<3>, 0);
}

TEST(FischerBurmeister, JacobianIsFiniteAtZeroAndOnTheEdgeOfTheCone) {
  const Local<3> zero = Local<3>::Zero();
  const Local<3> edge(1, 0.4, 0);  // mu s_n = |s_t| and u = 0: not differentiable
  for (const Local<3>& s : {zero, edge}) {
    const LocalResidual<3> r = fischer_burmeister<3>(s, zero, 0.4);
    EXPECT_TRUE(r.P.allFinite() && r.Q.allFinite() && r.f.allFinite());
    EXPECT_LT(r.f.norm(), 1e-14);
    EXPECT_GT((r.P + r.Q).norm(), 0.1);
  }
}

TEST(FischerBurmeister, KeepsItsDigitsForSlowSlip) {
  // x = (1, 1), y = (b, -b) with b = 1e-9: the smaller spectral value is 4 b², below rounding of
  // the larger one, 4. The exact residual is 0.
  const double mu = 1, b = 1e-9;
  const Local<2> s(1, 1), u(0, -b);
  EXPECT_LT(fischer_burmeister<2>(s, u, mu).f.norm(), 1e-15);
}

}  // namespace
}  // namespace bipot
