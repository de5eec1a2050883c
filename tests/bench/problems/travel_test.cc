// [time] travel: steps are cut where a body would go too far in one.

#include "core/scene/scene_parts.h"
#include "solvers/simulation/scene_stepper.h"
#include "solvers/simulation/split_step.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// A disk of 0.5 m at 10 m/s above a floor, in steps of 0.01 s: 0.1 m a step, a fifth of the
/// radius.
Scene<2> fall() {
  Scene<2> scene = one_law<2>({.mu = 0.3});
  scene.walls = {flat_floor<2>()};
  scene.bodies = {round_body<2>(Vec2(0, 0.647), 0.5, 2, Vec2(0, -10))};
  scene.step = 0.01;
  scene.num_steps = 10;
  scene.solver.name = "auto";
  scene.solver.tol = 1e-10;
  return scene;
}

TEST(Travel, CutsTheStepUntilNoBodyGoesFarther) {
  Scene<2> scene = fall();
  State<2> state = initial_state(scene);
  EXPECT_EQ(travel_halvings(scene, state), 0);
  scene.travel = 0.25;  // 0.125 m
  EXPECT_EQ(travel_halvings(scene, state), 0);
  scene.travel = 0.06;  // 0.03 m: a quarter of 0.1 m is less, a half is not
  EXPECT_EQ(travel_halvings(scene, state), 2);
  scene.gravity = Vec2(0, -1000);  // gains 10 m/s in the step: 0.2 m, an eighth of it
  EXPECT_EQ(travel_halvings(scene, state), 3);
  scene.travel = 1e-6;
  EXPECT_THROW(travel_halvings(scene, state), StepFailure);
}

TEST(Travel, SeesForcesDragAndTheFastestMomentOfAWall) {
  Scene<2> scene = fall();
  scene.bodies[0].v.setZero();
  scene.travel = 0.06;                                    // 0.03 m of 0.01 s: 3 m/s
  scene.forces = {{.last = 0, .force = Vec2(0, -1000)}};  // gains 5 m/s in the step
  EXPECT_EQ(travel_halvings(scene, initial_state(scene)), 1);
  scene.forces.clear();
  scene.drag = {.coefficient = 1e6, .velocity = Vec2(4, 0)};  // takes the body along at once
  EXPECT_EQ(travel_halvings(scene, initial_state(scene)), 1);
  scene.drag = {};
  // The sine is 0 in the middle of the step, 1 at a quarter of it.
  Wall<2>& wall = scene.walls[0];
  move_at(wall, Vec2(0, 4));
  wall.time_factor = {.frequency = 100};
  EXPECT_EQ(travel_halvings(scene, initial_state(scene)), 1);
  wall.time_factor = {.times = {0.001, 0.002, 0.003}, .factors = {0, -1, 0}};
  EXPECT_EQ(travel_halvings(scene, initial_state(scene)), 1);
  wall.time_factor = {.times = {0.1, 0.2}, .factors = {0, 1}};
  EXPECT_EQ(travel_halvings(scene, initial_state(scene)), 0);
}

// An image in the fiftieth cell above moves at 10 m/s with it, and stands still in it.
TEST(Travel, IsMeasuredAgainstTheCell) {
  Scene<2> scene = fall();
  scene.gravity = Vec2::Zero();
  scene.walls.clear();
  scene.travel = 0.01;
  scene.cell.in_x = scene.cell.in_y = true;
  scene.cell.width.length = scene.cell.height.length = 2.5;
  scene.cell.offset = {.motion = CellSide::Motion::kMoving, .speed = 0.2};
  for (const int k : {0, 50}) {
    scene.bodies = {round_body<2>(Vec2(0.7, 0.6 + 2.5 * k), 0.5, 2, Vec2(0.2 * k, 0))};
    State<2> state = initial_state(scene);
    EXPECT_EQ(travel_halvings(scene, state), 0) << k;
    EXPECT_LT(SceneStepper<2>(scene, {}).advance(state).travel, 1e-12) << k;
  }
}

TEST(Travel, ALandingOverlapsByWhatAPartGoesAndRestTakesWholeSteps) {
  Scene<2> scene = fall();
  for (const double travel : {0.0, 0.06}) {
    scene.travel = travel;
    ASSERT_EQ(validate(scene), "");
    State<2> state = initial_state(scene);
    SceneStepper<2> stepper(scene);
    double imbalance = 0;
    int parts = 0;
    for (int k = 0; k < 10; ++k) {
      const StepReport<2> report = stepper.advance(state);
      EXPECT_TRUE(report.converged) << report.message;
      imbalance = std::max(imbalance, std::abs(report.energy.imbalance));
      parts += stepper.parts();
    }
    EXPECT_EQ(state.step, 10);
    EXPECT_DOUBLE_EQ(state.time, 0.1);
    // The gap, 0.147 m, in the middle of the steps: 0.097, -0.003 m: the disk is held there. In
    // parts of 0.025 m the middles are at 0.1345 m less 0.025 m each, the sixth at 0.0095, the
    // seventh at -0.0155 m.
    EXPECT_NEAR(state.bodies[0].x[1] - 0.5, travel > 0 ? -0.0155 : -0.003, 1e-12);
    EXPECT_NEAR(state.bodies[0].v[1], 0, 1e-12);
    EXPECT_NEAR(state.shock_loss, 100, 1e-9);
    EXPECT_LT(imbalance, 1e-10);
    // Two steps in four parts, then nothing moves.
    EXPECT_EQ(parts, travel > 0 ? 2 * 4 + 8 : 10);
  }
}

TEST(Travel, AFastWallIsCutAsAFastDisk) {
  // The same landing in two frames, with a gap of 0.18 m; g = 0. The middles of the quarters, at
  // 0.18 - 0.0125 - 0.025 k m, end 0.0075 m inside.
  double overlap[2];
  for (const bool wall_moves : {false, true}) {
    Scene<2> scene = fall();
    scene.travel = 0.06;
    scene.bodies[0].x[1] = 0.68;
    if (wall_moves) {
      scene.bodies[0].v.setZero();
      scene.walls[0].v = Vec2(0, 10);
      scene.walls[0].motion = Wall<2>::Motion::kMoving;
    }
    ASSERT_EQ(validate(scene), "");
    State<2> state = initial_state(scene);
    EXPECT_EQ(travel_halvings(scene, state), 2);
    SceneStepper<2> stepper(scene);
    double penetration = 0;
    for (int k = 0; k < 4; ++k) {
      penetration = std::max(penetration, stepper.advance(state).penetration);
    }
    overlap[wall_moves ? 1 : 0] = penetration;
  }
  EXPECT_NEAR(overlap[0], 0.0075, 1e-12);
  EXPECT_NEAR(overlap[1], 0.0075, 1e-12);
}

TEST(Travel, ARestartBetweenTheStepsGoesOnBitForBit) {
  Scene<2> scene = fall();
  scene.travel = 0.06;
  State<2> whole = initial_state(scene), halfway = whole;
  SceneStepper<2> stepper(scene), before(scene), after(scene);
  for (int k = 0; k < 4; ++k) stepper.advance(whole);
  before.advance(halfway);
  for (int k = 0; k < 3; ++k) after.advance(halfway);
  EXPECT_EQ(whole.bodies[0].x, halfway.bodies[0].x);
  EXPECT_EQ(whole.shock_loss, halfway.shock_loss);
}

}  // namespace
}  // namespace bipot
