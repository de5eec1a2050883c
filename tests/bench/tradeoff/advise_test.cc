#include "bench/tradeoff/advise.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "bench/problems/moving_scene.h"
#include "core/scene/scene_family.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

/// A triangular lattice of 4 rows comes to its first rest: static, so that any step size will do.
Scene<2> lattice() {
  Scene<2> scene = make_family_scene("triangular", 4);
  scene.num_steps = 20;
  return scene;
}

AdviseOptions quick(double force) {
  AdviseOptions options;
  options.goal.force = force;
  options.solvers = {{"pgs", "pgs", {}}, {"ipm", "ipm", {}}};
  options.time_limit = 120;  // never reached: what is measured does not hang on the machine
  return options;
}

/// A disk of 1 m dropped from a height of 5 mm or so: one shock in mid-run.
Scene<2> drop() {
  Scene<2> scene = make_family_scene("square", 1);
  scene.walls.resize(1);
  scene.bodies[0].x[1] += 0.005;
  scene.step = 1e-3;
  scene.num_steps = 100;
  return scene;
}

TEST(Advise, MeetsTheGoalOnStepsThatItWasNotChosenOn) {
  const Advice advice = advise(lattice(), quick(1e-2));
  ASSERT_EQ(advice.status, Advice::Status::kMet) << advice.message;
  ASSERT_GE(advice.choice, 0);
  const SolverTrial& chosen = advice.trials[advice.choice];
  EXPECT_EQ(chosen.verdict, SolverTrial::Verdict::kChosen);
  EXPECT_LE(chosen.error.force, 1e-2);
  EXPECT_LE(chosen.stretch.force, 1e-2);
  EXPECT_GE(advice.fresh.problems, 1);
  EXPECT_LE(advice.fresh.error.force, 1e-2);
  EXPECT_EQ(advice.sample.steps_run, 20);
  EXPECT_LE(advice.worst_reference, 1e-5);  // a thousandth of the goal
  // At rest a larger step changes nothing: the largest is taken, for the same simulated time.
  EXPECT_DOUBLE_EQ(advice.step_size, 4 * 0.01);
  EXPECT_EQ(advice.num_steps, 5);
}

TEST(Advise, OverStretchesNothingBelowTheSpreadOfExactRunsIsPaidFor) {
  // The lattice at rest has one velocity and, kept by the shared criterion, forces of bodies that
  // any solver finds: two tight runs agree far below the goal, and nothing is said of them.
  const Advice still = advise(lattice(), quick(1e-2));
  EXPECT_LE(still.stretch_spread.force, 1e-4);
  EXPECT_EQ(still.message.find("same stretches"), std::string::npos) << still.message;
  // 64 disks poured into a tilted box: steps with several exact answers, each the start of the
  // next.
  Scene<2> heap = make_moving_scene("tilt", 8, {.seed = 3});
  AdviseOptions options = quick(1e-6);
  options.solvers = {{"auto", "auto", {}}};
  options.keep_step = true;
  const Advice advice = advise(heap, options);
  ASSERT_GT(advice.stretch_spread.force, 1e-6) << advice.message;
  EXPECT_NE(advice.message.find("same stretches"), std::string::npos) << advice.message;
  for (const SolverTrial& t : advice.trials) {
    if (t.verdict != SolverTrial::Verdict::kStretchMissed) continue;
    EXPECT_GT(t.stretch.force, 0.5 * advice.stretch_spread.force);
  }
}

TEST(Advise, AGoalOnForcesAsksForFinerStepsThroughAShock) {
  const Advice advice = advise(drop(), quick(1e-2));
  ASSERT_FALSE(advice.steps.steps.empty());
  // The shock's time is known to a step: the error of the mean force over a window of 16 of the
  // scene's steps falls with the step, from more than 10 % at four times the scene's.
  const StepTrial &largest = advice.steps.steps.front(), &smallest = advice.steps.steps.back();
  EXPECT_DOUBLE_EQ(largest.step, 4e-3);
  EXPECT_DOUBLE_EQ(smallest.step, 2.5e-4);
  EXPECT_GT(largest.error.force, 0.1);
  EXPECT_LT(smallest.error.force, 0.5 * largest.error.force);
}

TEST(Advise, TheScenesStepIsKeptOnRequest) {
  AdviseOptions options = quick(1e-2);
  options.keep_step = true;
  const Advice advice = advise(lattice(), options);
  EXPECT_EQ(advice.status, Advice::Status::kMet) << advice.message;
  EXPECT_DOUBLE_EQ(advice.step_size, 0.01);
  EXPECT_EQ(advice.steps.steps.size(), 1u);
}

TEST(Advise, SaysWhatCannotBeMet) {
  AdviseOptions options = quick(1e-2);
  options.goal = {.penetration = 1e-12};
  const Advice advice = advise(drop(), options);
  EXPECT_EQ(advice.status, Advice::Status::kNotMet);
  EXPECT_NE(advice.message.find("no time step"), std::string::npos) << advice.message;
  EXPECT_NE(advice.message.find("penetration"), std::string::npos) << advice.message;
  // Half of the step's own error: no digits that the step throws away.
  EXPECT_NEAR(advice.budget.penetration, 0.5 * advice.step_error.penetration, 1e-15);
}

TEST(Advise, SaysThatNothingTouches) {
  Scene<2> scene = drop();
  scene.bodies[0].x[1] += 10;
  const Advice advice = advise(scene, quick(1e-2));
  EXPECT_EQ(advice.status, Advice::Status::kNoContacts);
  EXPECT_LT(advice.choice, 0);
}

TEST(Advise, RefusesGoalsWithoutMeaning) {
  EXPECT_THROW(advise(lattice(), quick(0)), std::invalid_argument);
  EXPECT_THROW(advise(lattice(), quick(-1)), std::invalid_argument);
  AdviseOptions nothing = quick(1e-2);
  nothing.goal = {};
  EXPECT_THROW(advise(lattice(), nothing), std::invalid_argument);
  AdviseOptions unknown = quick(1e-2);
  unknown.solvers = {{"pgz", "pgz", {}}};
  EXPECT_THROW(advise(lattice(), unknown), std::invalid_argument);
  // What measures body by body needs the same single bodies throughout.
  Scene<2> leaking = lattice();
  leaking.outlets.resize(1);
  EXPECT_THROW(advise(leaking, quick(1e-2)), std::invalid_argument);
}

TEST(Advise, TakesClusters) {
  // Dumbbells that fall on a floor: the force on a body is that on the whole cluster.
  for (const double mu : {0.0, 0.3}) {
    Scene<2> scene = parse_scene(fmt::format(R"(
[contact]
mu = {}
[[clusters]]
arrangement = "rectangular"
parts = [[0, 0, 0.1], [0.15, 0, 0.1]]
columns = 2
rows = 2
density = 100
[[walls]]
point = [0, 0.07]
normal = [0, 1]
[time]
step = 1e-3
steps = 60
)",
                                             mu),
                                 "test.toml");
    const Advice advice = advise(scene, quick(1e-1));
    EXPECT_NE(advice.status, Advice::Status::kInterrupted) << advice.message;
    ASSERT_FALSE(advice.trials.empty());
    bool measured = false;
    for (const SolverTrial& trial : advice.trials) {
      measured = measured || std::isfinite(trial.error.force);
    }
    EXPECT_TRUE(measured) << mu;
  }
}

TEST(Advise, EndsWhenInterrupted) {
  AdviseOptions options = quick(1e-2);
  options.interrupted = [] { return true; };
  EXPECT_EQ(advise(lattice(), options).status, Advice::Status::kInterrupted);
}

}  // namespace
}  // namespace bipot
