#include "solvers/interior/equal_product_start.h"

#include "core/problem/delassus.h"
#include "tests/support/manufactured.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

template <ContactRows D>
void expect_equal_products() {
  Manufactured m =
      D.rolls ? manufactured_rolling(D, 20, 30, 5) : manufactured_problem(D, 20, 30, 5);
  if (D > 1) m.problem.mu[4] = 0;
  if (D.rolls) m.problem.mu_r[4] = m.problem.mu_r[5] = 0;
  const DelassusOperator delassus(m.problem);
  InteriorSystem<D> system(m.problem, delassus, ShiftedDelassus::Form::kAuto);
  const EqualProductStart starts{system};
  // From far outside the cones as well.
  for (const double factor : {1.0, -2.0}) {
    const Vector s0 = factor * m.s;
    const double tau = 1e-6 * starts.normal_energy(m.s);
    const InteriorState<D> z = starts.warm(s0, tau);
    const Vector products = system.products(z.X, z.Y);
    for (int c = 0; c < system.num_contacts(); ++c) {
      const unsigned f = system.parts(c);
      for (const double e : ContactJordan<D>::eigenvalues(system.pairs(products, c), f)) {
        EXPECT_NEAR(e, tau, 1e-6 * tau) << c;
      }
      EXPECT_GT(ContactJordan<D>::eigenvalues(system.pairs(z.X, c), f).minCoeff(), 0);
      // The local law: W_nn (s_n - z_n) = w, W_tt (s_t - z_t) = u_t.
      Vector u0;
      delassus.velocity(s0, u0);
      Local<D> off =
          local<D>(system.mobility(), c).cwiseProduct(local<D>(z.s, c) - local<D>(s0, c)) +
          local<D>(u0, c);
      const Local<D> u = ContactJordan<D>::velocity_of_pairs(system.pairs(z.Y, c), f);
      off -= u;
      ContactJordan<D>::clear_smooth_rows(off, f);
      EXPECT_LT(off.norm(), 1e-6 * (u.norm() + local<D>(u0, c).norm())) << D << " " << c;
    }
  }
}

TEST(EqualProductStart, WarmStartSolvesTheSmoothedLocalLawWithEqualProducts) {
  expect_equal_products<1>();
  expect_equal_products<2>();
  expect_equal_products<3>();
  expect_equal_products<ContactRows(3, true)>();
  expect_equal_products<ContactRows(6, true)>();
}

TEST(EqualProductStart, WarmStartTendsToTheSolution) {
  const Manufactured m = manufactured_problem(2, 20, 30, 5);
  const DelassusOperator delassus(m.problem);
  InteriorSystem<2> system(m.problem, delassus, ShiftedDelassus::Form::kAuto);
  const EqualProductStart starts{system};
  double last = kInfinity;
  for (const double tau : {1e-4, 1e-8, 1e-12}) {
    const double distance = (starts.warm(m.s, tau * starts.normal_energy(m.s)).s - m.s).norm();
    EXPECT_LT(distance, 0.1 * last) << tau;
    last = distance;
  }
}

TEST(EqualProductStart, ColdStartHasTheGivenProducts) {
  const Manufactured m = manufactured_problem(3, 20, 30, 5);
  const DelassusOperator delassus(m.problem);
  InteriorSystem<3> system(m.problem, delassus, ShiftedDelassus::Form::kAuto);
  EqualProductStart starts{system};
  const double energy = starts.spring_energy();
  EXPECT_GT(energy, 0);
  const InteriorState<3> z = starts.cold(energy, 10);
  const Vector products = system.products(z.X, z.Y);
  EXPECT_NEAR(system.mean_product(products), 10 * energy, 1e-12 * energy);
  EXPECT_NEAR(system.smallest_product(products), 10 * energy, 1e-12 * energy);
  EXPECT_NEAR(starts.normal_energy(z.s), 100 * energy, 1e-11 * energy);
}

}  // namespace
}  // namespace bipot
