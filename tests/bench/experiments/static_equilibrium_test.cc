#include "bench/experiments/static_equilibrium.h"

#include "core/criterion/contact_error.h"
#include "core/motion/time_stepping.h"
#include "core/scene/scene_family.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Pyramid of `rows`, friction mu between disks and mu_floor against the floor.
ContactProblem pyramid_problem(int rows, double mu, double mu_floor) {
  Scene<2> scene = make_family_scene("pyramid", rows, {.mu = mu});
  scene.materials = {"disk", "floor"};
  scene.laws = {{mu, 0, 0}, {mu_floor, 0, 0}, {mu_floor, 0, 0}, {mu, 0, 0}};
  scene.walls[0].material = 1;
  return step_problem(scene, initial_state(scene));
}

// Three disks, by hand: at rest the force on a lower disk from the top one must pass through its
// floor contact (three forces, two of them through that point), hence tan 15 degrees between it and
// the contact normal; the floor then takes 3/2 of the weight down and tan 15 / 2 sideways.
TEST(StaticEquilibrium, ThreeDisksNeedTheFrictionFoundByHand) {
  const double tan15 = 2 - std::sqrt(3.0);
  const auto disks = [](double mu) { return pyramid_problem(2, mu, 5); };
  const auto floor = [](double mu) { return pyramid_problem(2, 5, mu); };
  EXPECT_NEAR(critical_friction(disks, 0.01, 5) / tan15, 1, 1e-6);
  EXPECT_NEAR(critical_friction(floor, 0.01, 5) / (tan15 / 3), 1, 1e-6);
  EXPECT_TRUE(std::isnan(critical_friction(disks, 0.01, 0.2)));
  EXPECT_EQ(critical_friction(disks, 0.3, 5), 0.3);
}

TEST(StaticEquilibrium, ImpulseSolvesTheContactLaw) {
  const ContactProblem problem = pyramid_problem(6, 0.6, 0.6);
  const StaticEquilibrium found = static_equilibrium(problem);
  ASSERT_TRUE(found.exists);
  EXPECT_LE(contact_error(problem, found.s).guarded(), 1e-9);
}

TEST(StaticEquilibrium, MotionProvesThatThereIsNone) {
  const ContactProblem problem = pyramid_problem(6, 0.4, 0.4);
  const StaticEquilibrium found = static_equilibrium(problem);
  ASSERT_FALSE(found.exists);
  EXPECT_GT(found.motion, 1e-3);
  const Vector u = problem.H.transpose() * found.v;
  const double scale = problem.v_free.cwiseAbs().maxCoeff();
  for (int k = 0; k < problem.num_contacts(); ++k) {
    EXPECT_GE(u[2 * k] - 0.4 * std::abs(u[2 * k + 1]), -1e-9 * scale) << "contact " << k;
  }
  EXPECT_GT(found.v.dot(problem.A * problem.v_free), 0);
}

TEST(StaticEquilibrium, RefusesProblemsOfAnotherForm) {
  ContactProblem problem = pyramid_problem(2, 0.5, 0.5);
  problem.row_scale = Vector::Constant(problem.num_rows(), 1.2);
  EXPECT_THROW(static_equilibrium(problem), std::invalid_argument);
}

}  // namespace
}  // namespace bipot
