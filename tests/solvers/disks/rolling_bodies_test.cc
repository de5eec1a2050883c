#include "solvers/disks/rolling_bodies.h"

#include "core/motion/time_stepping.h"
#include "core/scene/scene_family.h"
#include "core/scene/scene_parts.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(RollingBodies, DisksAreThoseWhoseThirdRowsHaveTheDifferenceOfTheSpins) {
  Scene<2> scene = make_family_scene("triangular", 4);
  EXPECT_FALSE(rolling_bodies<kRollingDisks>(step_problem(scene, initial_state(scene))));
  for (ContactLaw& law : scene.laws) law.mu_r = 0.02;
  const ContactProblem p = step_problem(scene, initial_state(scene));
  const auto disks = rolling_bodies<kRollingDisks>(p);
  ASSERT_TRUE(disks);
  EXPECT_EQ(disks->surroundings(), 14);  // rows of 4 and 3
  EXPECT_EQ(static_cast<int>(disks->contacts.size()), p.num_contacts());
  EXPECT_NEAR(disks->bodies[0].inverse_inertia, 2, 1e-12);  // a²/I of 1 kg
  // A row of two disks whose entries do not match.
  int pair = 0;
  while (disks->contacts[to_size(pair)].j == disks->surroundings()) ++pair;
  for (int row = 0; row < 3; ++row) {
    ContactProblem other = p;
    SparseMatrix::InnerIterator it(other.H, 3 * pair + row);
    while (std::abs(it.value()) < 0.1) ++it;
    it.valueRef() *= 1.5;
    EXPECT_FALSE(rolling_bodies<kRollingDisks>(other)) << row;
  }
  EXPECT_FALSE(rolling_bodies<kRollingDisks>(local_form(p)));
  drive(scene.walls[0], scene.walls[0].normal, 1);  // it has no spin
  const ContactProblem pressed = step_problem(scene, initial_state(scene));
  ASSERT_EQ(pressed.num_dofs() % 3, 1);
  EXPECT_FALSE(rolling_bodies<kRollingDisks>(pressed));
}

TEST(RollingBodies, SpheresAreThoseWhoseLastRowsTurnAboutTheTangentsAndTheNormal) {
  Scene<3> scene = one_law<3>({.mu = 0.3});
  scene.bodies = {round_body<3>({0, 0, 0.5}, 0.5, 1), round_body<3>({0.6, 0.48, 1.14}, 0.5, 2)};
  scene.walls = {flat_floor<3>()};
  EXPECT_FALSE(rolling_bodies<kRollingSpheres>(step_problem(scene, initial_state(scene))));
  scene.laws[0] = {.mu = 0.3, .e_t = 0.5, .mu_r = 0.02, .mu_spin = 0.01};
  const ContactProblem p = step_problem(scene, initial_state(scene));
  ASSERT_EQ(p.dim, 6);
  const auto spheres = rolling_bodies<kRollingSpheres>(p);
  ASSERT_TRUE(spheres);
  EXPECT_EQ(spheres->surroundings(), 2);
  EXPECT_NEAR(spheres->bodies[0].arm, 0.5, 1e-12);
  EXPECT_FALSE(rolling_bodies<kRollingDisks>(p));
  int pair = 0;
  while (spheres->contacts[to_size(pair)].j == spheres->surroundings()) ++pair;
  for (int row = 6 * pair; row < 6 * pair + 6; ++row) {
    ContactProblem other = p;
    SparseMatrix::InnerIterator it(other.H, row);
    while (std::abs(it.value()) < 0.1) ++it;
    it.valueRef() *= 1.5;
    EXPECT_FALSE(rolling_bodies<kRollingSpheres>(other)) << row;
  }
  EXPECT_FALSE(rolling_bodies<kRollingSpheres>(local_form(p)));
}

}  // namespace
}  // namespace bipot
