// overlaps = "predict": pairs that would meet before they are looked at again take part.

#include "core/motion/midpoint.h"
#include "core/scene/scene_family.h"
#include "tests/support/scene_run.h"

namespace bipot {
namespace {

struct Landed {
  State<2> end;
  double imbalance = 0, penetration = 0;  // largest of a step
};

template <int D>
Landed advance(const Scene<D>& scene, State<D>& state, int steps) {
  TimeStepper<D> stepper = stepper_of(scene, "auto", {.tol = 1e-12});
  Landed landed;
  for (int k = 0; k < steps; ++k) {
    const StepReport<D> r = stepper.advance(state);
    EXPECT_TRUE(r.converged) << r.message;
    landed.imbalance = std::max(landed.imbalance, std::abs(r.energy.imbalance));
    landed.penetration = std::max(landed.penetration, r.penetration);
  }
  return landed;
}

/// A disk of 0.5 m and 2 kg falls at 10 m/s on a floor; h = 0.01 s. In the middle of its first
/// step, at 0.05 m less, its gap is 0.03 m.
Scene<2> fall(const ContactLaw& law) {
  Scene<2> scene = one_law<2>(law);
  scene.walls = {flat_floor<2>()};
  scene.bodies = {round_body<2>(Vec2(0, 0.58), 0.5, 2, Vec2(0, -10))};
  scene.step = 0.01;
  return scene;
}

TEST(PredictedGaps, AFastDiskTouchesInTheMiddleOfTheNextStepAndStaysThere) {
  Scene<2> scene = fall({.mu = 0.3});
  for (const bool predict : {false, true}) {
    scene.predict_gaps = predict;
    ASSERT_EQ(validate(scene), "");
    State<2> state = initial_state(scene);
    advance(scene, state, 1);
    // Seen ahead, it keeps the speed 0.03 m / 0.01 s that closes the gap by the next midpoint, and
    // ends half a step before; else it goes on.
    EXPECT_NEAR(state.bodies[0].v[1], predict ? -3 : -10, 1e-12);
    EXPECT_NEAR(state.bodies[0].x[1], predict ? 0.515 : 0.48, 1e-12);
    // All of its energy is a shock's loss, ½ 2 kg (10 m/s)², in one step or in two.
    const Landed landed = advance(scene, state, 5);
    EXPECT_NEAR(state.bodies[0].v[1], 0, 1e-12);
    EXPECT_NEAR(state.bodies[0].x[1], predict ? 0.5 : 0.43, 1e-12);
    EXPECT_NEAR(landed.penetration, predict ? 0 : 0.07, 1e-12);
    EXPECT_NEAR(state.shock_loss, 100, 1e-9);
    EXPECT_LT(landed.imbalance, 1e-10);
  }
}

// At rest 0.02 m above the floor: the force of 2 kg 400 m/s² would make it go 0.04 m in a step.
TEST(PredictedGaps, LookAsFarAsForcesCarry) {
  Scene<2> scene = fall({.mu = 0.3});
  scene.bodies[0].x[1] = 0.52;
  scene.bodies[0].v.setZero();
  scene.forces = {{.last = 0, .force = Vec2(0, -800)}};
  scene.predict_gaps = true;
  State<2> state = initial_state(scene);
  const Landed landed = advance(scene, state, 10);
  EXPECT_NEAR(landed.penetration, 0, 1e-12);
  EXPECT_NEAR(state.bodies[0].x[1], 0.5, 1e-12);
}

TEST(PredictedGaps, HoldInSpaceAndBetweenTwoBodies) {
  // Two balls of 0.5 m and 2 kg meet head on at 10 and 6 m/s; the gap in the middle of the step is
  // 0.05 m: it closes by 0.16 m a step. Afterwards both have the mean velocity, 2 m/s.
  Scene<3> scene = one_law<3>({.mu = 0.3});
  scene.bodies = {round_body<3>(Vec3(-0.565, 0, 0), 0.5, 2, Vec3(10, 0, 0)),
                  round_body<3>(Vec3(0.565, 0, 0), 0.5, 2, Vec3(-6, 0, 0))};
  scene.step = 0.01;
  scene.predict_gaps = true;
  ASSERT_EQ(validate(scene), "");
  State<3> state = initial_state(scene);
  const Landed landed = advance(scene, state, 3);
  EXPECT_NEAR(state.bodies[1].x[0] - state.bodies[0].x[0], 1, 1e-12);
  EXPECT_NEAR(state.bodies[0].v[0], 2, 1e-12);
  EXPECT_NEAR(state.bodies[1].v[0], 2, 1e-12);
  EXPECT_LT(landed.penetration, 1e-12);
  EXPECT_LT(landed.imbalance, 1e-10);
}

TEST(PredictedGaps, ALooseBoxfulEndsAtRestWithLessOverlapThanItFallsInAStep) {
  Scene<2> scene = make_family_scene("random", 5, {.mu = 0.3, .seed = 2});
  scene.step = 0.01;
  double overlap[2];
  for (const bool predict : {false, true}) {
    scene.predict_gaps = predict;
    State<2> state = initial_state(scene);
    const Landed landed = advance(scene, state, 200);
    EXPECT_LT(landed.imbalance, 1e-9 * 1e4);
    overlap[predict ? 1 : 0] = landed.penetration;
  }
  // Without prediction a disk that lands at v overlaps by up to v h; with it only those that others
  // push do, in a step in which they were slow.
  EXPECT_LT(overlap[1], 0.5 * overlap[0]);
}

TEST(PredictedGaps, PairsThatCannotMeetStayOut) {
  Scene<2> scene = fall({.mu = 0.3});
  scene.predict_gaps = true;
  State<2> state = initial_state(scene);
  // 10 m/s and 0.01 s: 0.1 m a step, and a gap of 0.11 m in its middle.
  state.bodies[0].x[1] = 0.66;
  EXPECT_EQ(make_midpoint(scene, state).contacts.size(), 0u);
  state.bodies[0].x[1] = 0.64;
  EXPECT_EQ(make_midpoint(scene, state).contacts.size(), 1u);
}

TEST(PredictedGaps, AreRefusedWithRestitution) {
  Scene<2> scene = fall({.mu = 0.3, .e_n = 0.5});
  scene.predict_gaps = true;
  EXPECT_TRUE(says(validate(scene), "e_n"));
}

}  // namespace
}  // namespace bipot
