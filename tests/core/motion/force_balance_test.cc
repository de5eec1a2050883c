#include "core/motion/force_balance.h"

#include "core/scene/scene_family.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

// A disk of 1 kg on a floor, radius 0.5 m: s_n = m g h balances; s_t = 0.01 N s more leaves the
// force 0.01/h and the moment 0.01 a/h.
TEST(ForceBalance, SumsForcesAndMoments) {
  Scene<2> scene = make_family_scene("square", 1, {});
  State<2> state = initial_state(scene);
  state.contacts = {{.contact = {.i = 0, .j = 1, .n = Vec2(0, 1)}, .s_n = 9.81 * scene.step}};
  EXPECT_NEAR(force_balance(scene, state).force, 0, 1e-15);
  state.contacts[0].s_t = 0.01;
  const ForceBalance<2> balance = force_balance(scene, state);
  EXPECT_NEAR(balance.force, 0.01 / scene.step / 9.81, 1e-12);
  EXPECT_NEAR(balance.moment, 0.01 / scene.step / 9.81, 1e-12);
  EXPECT_NEAR(balance.weight, 9.81, 1e-12);
  EXPECT_NEAR(balance.wall[0][1], 9.81, 1e-12);
  EXPECT_NEAR(balance.walls[0], -0.01 / scene.step, 1e-12);  // t = e3 x n = (-1, 0)
}

}  // namespace
}  // namespace bipot
