#include "solvers/disks/rolling_disks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/motion/time_stepping.h"
#include "core/scene/scene_family.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

TEST(RollingDisks, AreThoseWhoseThirdRowsHaveTheDifferenceOfTheSpins) {
  Scene<2> scene = make_family_scene("triangular", 4);
  EXPECT_FALSE(rolling_disks(step_problem(scene, initial_state(scene), false)));
  for (ContactLaw& law : scene.laws) law.mu_r = 0.02;
  const ContactProblem p = step_problem(scene, initial_state(scene), false);
  const auto disks = rolling_disks(p);
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
    EXPECT_FALSE(rolling_disks(other)) << row;
  }
  EXPECT_FALSE(rolling_disks(local_form(p)));
  scene.walls[0].motion = Wall<2>::Motion::kDriven;  // it has no spin
  scene.walls[0].direction = scene.walls[0].normal;
  scene.walls[0].mass = 1;
  const ContactProblem pressed = step_problem(scene, initial_state(scene), false);
  ASSERT_EQ(pressed.num_dofs() % 3, 1);
  EXPECT_FALSE(rolling_disks(pressed));
}

}  // namespace
}  // namespace bipot
