#include "bench/tradeoff/advise.h"

#include "bench/problems/moving_scene.h"
#include "bench/problems/scene_catalogue.h"
#include "bench/report/text_lines.h"
#include "bench/tradeoff/advice_report.h"
#include "bench/tradeoff/run_setting.h"
#include "core/scene/scene_family.h"
#include "core/scene/scene_parts.h"
#include "solvers/simulation/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// A triangular lattice of 4 rows comes to its first rest: static, so that any step size will do.
Scene<2> lattice() {
  Scene<2> scene = make_family_scene("triangular", 4);
  scene.num_steps = 40;
  return scene;
}

Advice::Options quick(const Accuracy& goal) {
  return {.goal = goal,
          .solvers = {{"pgs", "pgs", {}}, {"ipm", "ipm", {}}},
          .time_limit = 120};  // never reached: what is measured does not hang on the machine
}
Advice::Options quick(double force) { return quick(Accuracy{.force = force}); }

/// A disk of 1 m dropped from a height of 5 mm or so: one shock in mid-run.
Scene<2> drop() {
  Scene<2> scene = make_family_scene("square", 1);
  scene.walls.resize(1);
  scene.bodies[0].x[1] += 0.005;
  scene.step = 1e-3;
  scene.num_steps = 100;
  return scene;
}

TEST(Advise, MeetsTheGoalOnStretchesAndInTheRun) {
  const Advice advice = advise(lattice(), quick(1e-2));
  ASSERT_EQ(advice.status, Advice::Status::kMet) << advice.message;
  ASSERT_GE(advice.choice, 0);
  const Advice::SolverTrial& chosen = advice.trials[advice.choice];
  EXPECT_EQ(chosen.verdict, Advice::SolverTrial::Verdict::kChosen);
  EXPECT_LE(chosen.error.bound().force, 1e-2);
  EXPECT_EQ(advice.sample.steps_run, 40);
  EXPECT_TRUE(advice.run.whole());
  // At rest a larger step changes nothing: the largest is taken, for the same simulated time.
  EXPECT_DOUBLE_EQ(advice.step_size, 4 * 0.01);
  EXPECT_EQ(advice.num_steps, 10);
}

TEST(Advise, SaysThatCohesionWithoutARangeDependsOnTheStep) {
  Scene<2> scene = lattice();
  for (ContactLaw& law : scene.laws) law = {.mu = law.mu, .e_t = law.e_t, .cohesion = 1};
  for (const double range : {0.0, 1e-6}) {
    scene.cohesion_range = range;
    Advice::Options options = quick(1e-2);
    options.keep_step = true;
    const std::string text = advice_summary(advise(scene, options));
    EXPECT_EQ(text.find("cohesion_range") != std::string::npos, range == 0) << text;
  }
}

TEST(Advise, OverStretchesNothingBelowTheSpreadOfExactRunsIsPaidFor) {
  // The lattice at rest has one velocity and, kept by the shared criterion, forces of bodies that
  // any solver finds: two tight runs agree far below the goal, and nothing is said of them.
  const Advice still = advise(lattice(), quick(1e-2));
  EXPECT_LE(still.spread.force, 1e-4);
  EXPECT_FALSE(says(still.message, "exact runs of the same stretches")) << still.message;
  // 64 disks poured into a tilted box: steps with several exact answers, each the start of the
  // next.
  Scene<2> heap = make_moving_scene("tilt", 8, {.seed = 3});
  Advice::Options options = quick(1e-6);
  options.solvers = {{"auto", "auto", {}}};
  options.keep_step = true;
  const Advice advice = advise(heap, options);
  ASSERT_GT(advice.spread.force, 1e-6) << advice.message;
  EXPECT_TRUE(says(advice.message, "exact runs of the same stretches"));
  for (const Advice::SolverTrial& t : advice.trials) {
    if (t.verdict != Advice::SolverTrial::Verdict::kMissed || t.solved < t.stretches) continue;
    EXPECT_GT(t.error.bound().force, advice.spread.force);
  }
}

TEST(Advise, AGoalOnForcesAsksForFinerStepsThroughAShock) {
  const Advice advice = advise(drop(), quick(1e-2));
  ASSERT_FALSE(advice.steps.steps.empty());
  // The shock's time is known to a step: the error of the mean force over a window of 16 of the
  // scene's steps falls with the step, from more than 10 % at four times the scene's.
  const auto equal = std::count_if(advice.steps.steps.begin(), advice.steps.steps.end(),
                                   [](const Advice::StepTrial& t) { return t.accuracy == 0; });
  const Advice::StepTrial& largest = advice.steps.steps.front();
  const Advice::StepTrial& smallest = advice.steps.steps.at(to_size(equal - 1));
  EXPECT_DOUBLE_EQ(largest.step, 4e-3);
  EXPECT_DOUBLE_EQ(smallest.step, 2.5e-4);
  EXPECT_GT(largest.error.error.force, 0.1);
  EXPECT_LT(smallest.error.error.force, 0.5 * largest.error.error.force);
}

TEST(Advise, ItsCommandsAreForAShellAndAPlanKeepsTheAdvice) {
  Advice advice;
  advice.scene = "my süß scene.toml";
  advice.scene_step = 1e-3;
  advice.step_size = 2e-3;
  advice.num_steps = 50;
  advice.trials = {{.solver = {"pgs omega=1.5", "pgs", {{"omega", "1.5"}}}, .tol = 1e-2}};
  advice.choice = 0;
  advice.run = {.steps = 50, .steps_planned = 50, .overlap_step = -1};
  EXPECT_TRUE(says(to_text(advice_document(advice)), "50 of 50 steps, no overlap"));
  const std::string length = " --step-size 0.002 --steps 50";
  EXPECT_EQ(run_command_of(advice),
            "bipot run 'my süß scene.toml' --solver pgs --tol 0.01 --omega 1.5" + length);
  advice.other_stop = true;
  EXPECT_TRUE(says(run_command_of(advice), " --omega 1.5 --stop guarded --step-size"));
  advice.other_stop = false;
  EXPECT_EQ(
      run_command_of(advice, "its plan.toml"),
      "bipot run 'my süß scene.toml' --solver auto --tol 0.01 --plan 'its plan.toml'" + length);
}

/// `bipot run --solver NAME` keeps the scene's parameters where NAME is the scene's own solver.
TEST(Advise, TheScenesSolverIsTriedWithTheScenesParameters) {
  Scene<2> scene = lattice();
  scene.solver.name = "pgs";
  scene.solver.parameters = {{"omega", "0.7"}, {"order", "symmetric"}};
  Advice::Options options = quick(1e-2);
  options.solvers = {
      {"pgs", "pgs", {}}, {"pgs omega=1.5", "pgs", {{"omega", "1.5"}}}, {"apgd", "apgd", {}}};
  const Advice advice = advise(scene, options);
  ASSERT_GE(advice.choice, 0);
  for (const Advice::SolverTrial& trial : advice.trials) {
    std::map<std::string, std::string> expected = scene.solver.parameters;
    if (trial.solver.label == "pgs omega=1.5") expected["omega"] = "1.5";
    if (trial.solver.label == "apgd") expected.clear();
    EXPECT_EQ(trial.solver.parameters, expected) << trial.solver.label;
  }
}

TEST(Advise, TheScenesStepIsKeptOnRequest) {
  Advice::Options options = quick(1e-2);
  options.keep_step = true;
  const Advice advice = advise(lattice(), options);
  EXPECT_EQ(advice.status, Advice::Status::kMet) << advice.message;
  EXPECT_DOUBLE_EQ(advice.step_size, 0.01);
  EXPECT_EQ(advice.steps.steps.size(), 1u);
}

TEST(Advise, SaysWhatCannotBeMet) {
  const Advice advice = advise(drop(), quick(Accuracy{.penetration = 1e-12}));
  EXPECT_EQ(advice.status, Advice::Status::kNotMet);
  EXPECT_TRUE(says(advice.message, "the run as advised has an overlap of"));
  // Half of the step's own error: no digits that the step throws away.
  EXPECT_NEAR(advice.budget.penetration, 0.5 * advice.step_error.error.penetration, 1e-15);
}

// The disk of 0.5 m falls h before the floor stops it: at mid-step it is up to h v/2 = 0.3 m/s · 1 ms /
// 2 deep at the scene's step. Only one stretch of the run sees it.
TEST(Advise, TheOverlapIsThatOfTheRun) {
  Advice::Options options = quick(Accuracy{.penetration = 5e-2});
  options.samples = 1;
  const Advice advice = advise(drop(), options);
  ASSERT_EQ(advice.status, Advice::Status::kMet) << advice.message;
  ASSERT_TRUE(advice.run.whole());
  const Scene<2> as_advised = with_setting(
      drop(), {.step_factor = advice.step_size / drop().step, .accuracy = advice.accuracy});
  EXPECT_EQ(as_advised.num_steps, advice.num_steps);
  State<2> state = initial_state(as_advised);
  const SceneRun<2> run = run_scene(as_advised, state);
  EXPECT_EQ(advice.run.overlap_step, run.totals.overlap_step);
  EXPECT_NEAR(expected_error(advice).error.penetration, run.totals.overlap, 1e-6);
  EXPECT_GT(advice.step_error.error.penetration, 0);
  if (advice.accuracy > 0) return;
  EXPECT_GE(advice.step_error.error.penetration,
            advice.step_size / drop().step * 0.99 * advice.sample.overlap);
}

// At 0.3 m/s, an overlap of 1e-5 of 0.5 m asks for equal steps of 3e-5 s. They are not even tried, but
// an accuracy places the step on the shock.
TEST(Advise, AnAccuracyKeepsOverlapsSmallWhereNoEqualStepDoes) {
  Advice::Options options = quick(Accuracy{.penetration = 1e-5});
  const Advice advice = advise(drop(), options);
  ASSERT_EQ(advice.status, Advice::Status::kMet) << advice.message;
  EXPECT_EQ(advice.accuracy, 3.3e-6);
  EXPECT_DOUBLE_EQ(advice.step_size, 4e-3);  // a quarter of a stretch
  EXPECT_LE(advice.run.overlap, 1e-5);
  EXPECT_TRUE(says(run_command_of(advice), "--accuracy 3.3e-06 --step-size 0.004 --steps 25"));
  Advice inexact = advice;  // met is what was asked for alone
  inexact.step_error.error.energy = 0.4;
  EXPECT_TRUE(says(advice_summary(inexact), "energy, not asked for, 4.0e-1"));
  EXPECT_FALSE(says(advice_summary(advice), "not asked for"));
  options.keep_step = true;
  EXPECT_EQ(advise(drop(), options).accuracy, 0);
}

// A fall of 1 m with steps of 1 s goes through the floor in the second one. More time is no help.
TEST(Advise, ASceneThatFailsBeforeAContactIsNamed) {
  Scene<2> scene = drop();
  scene.step = 1;
  scene.num_steps = 100;
  scene.gravity = Vec2(0, -1e3);
  const Advice advice = advise(scene, quick(1e-2));
  EXPECT_EQ(advice.status, Advice::Status::kUndecided);
  EXPECT_TRUE(says(advice.message, "went through"));
  EXPECT_TRUE(says(advice.message, "mend the scene first"));
}

// A lid that comes down on a disk: no step has a solution. More time is no help.
TEST(Advise, AStepWithoutSolutionIsNoQuestionOfTime) {
  Scene<2> scene = drop();
  scene.bodies[0].x[1] = scene.bodies[0].radius;
  scene.walls.push_back(half_space<2>(2 * scene.bodies[0].x, Vec2(0, -1), "lid"));
  move_at(scene.walls.back(), Vec2(0, -0.1));
  scene.num_steps = 20;
  Advice::Options options = quick(1e-2);
  options.time_limit = 12;  // a quarter of it has room for several such steps
  const Advice advice = advise(scene, options);
  EXPECT_EQ(advice.status, Advice::Status::kNotMet);
  EXPECT_TRUE(says(advice.message, "were not solved"));
  EXPECT_FALSE(says(advice_summary(advice), "--accuracy"));
}

TEST(Advise, TakesMoreStretchesWhereOneHasNoBar) {
  Advice::Options options = quick(Accuracy{.energy = 0.5});
  options.samples = 1;
  const Advice advice = advise(lattice(), options);
  EXPECT_EQ(advice.status, Advice::Status::kMet) << advice.message;
  EXPECT_GT(advice.steps.windows, 2);
}

// 10 steps are one stretch, whatever is asked for. Four times the step would be 3 steps of 0.04 s.
TEST(Advise, OneStretchClaimsNothingAndNamesWhatWould) {
  Scene<2> scene = lattice();
  scene.num_steps = 10;
  Advice::Options options = quick(Accuracy{.energy = 5e-2, .load = 5e-2});
  options.samples = 28;
  const Advice advice = advise(scene, options);
  ASSERT_GE(advice.choice, 0) << advice.message;
  EXPECT_EQ(advice.status, Advice::Status::kUndecided);
  EXPECT_TRUE(says(advice.message, "a single stretch have no error bars")) << advice.message;
  EXPECT_TRUE(says(advice.message, "let it run for more than 0.1 s")) << advice.message;
  EXPECT_FALSE(says(advice.message, "--samples")) << advice.message;
  EXPECT_NEAR(advice.num_steps * advice.step_size, 0.1, 1e-15);
  EXPECT_DOUBLE_EQ(advice.steps.steps.front().step, 0.02);
  EXPECT_TRUE(std::isfinite(advice.spread.load));
  const std::string text = to_text(advice_document(advice));
  EXPECT_FALSE(says(text, "–")) << text;
  for (const Advice::SolverTrial& t : advice.trials) {
    if (t.verdict == Advice::SolverTrial::Verdict::kMissed) continue;
    EXPECT_LE(share_of(t.error.error, advice.goal), 1);
  }
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
  Advice::Options longer = quick(1e-2);
  longer.window = 0.5;
  EXPECT_TRUE(says(refusal_of<std::invalid_argument>([&] { advise(lattice(), longer); }),
                   "a window of 0.5 s is longer than the 0.4 s of the scene"));
  Advice::Options unknown = quick(1e-2);
  unknown.solvers = {{"pgz", "pgz", {}}};
  EXPECT_THROW(advise(lattice(), unknown), std::invalid_argument);
}

TEST(Advise, WithoutAGoalItTakesMeansOverTimeThatTheSceneHas) {
  const Accuracy heap = default_goal(lattice());
  EXPECT_EQ(heap.energy, 5e-2);
  EXPECT_EQ(heap.penetration, kDeepOverlap);
  EXPECT_EQ(heap.load, 5e-2);
  EXPECT_TRUE(std::isnan(heap.force));  // one body's
  EXPECT_TRUE(std::isnan(heap.coordination));
  EXPECT_TRUE(std::isnan(heap.stress_ratio));
  Scene<2> cell = lattice();
  cell.cell.in_x = true;
  EXPECT_EQ(default_goal(cell).stress_ratio, 5e-2);
  const Advice advice = advise(lattice(), quick(Accuracy{}));
  EXPECT_TRUE(advice.default_goal);
  EXPECT_EQ(advice.status, Advice::Status::kMet) << advice.message;
  // Five lines: choice, expected error, cost, verdict, command.
  const std::string text = advice_summary(advice);
  std::string line;
  for (std::istringstream lines(text); std::getline(lines, line);) {
    EXPECT_TRUE(letters(line) <= 100 || says(line, "bipot run")) << line;
  }
  for (const char* word : {"choice", "expected error", "no goal given", "cost", "met", "run it",
                           "bipot run generated --solver"}) {
    EXPECT_TRUE(says(text, word)) << word << "\n" << text;
  }
}

TEST(Advise, SaysThatTimeWasUpAndNotThatNoSolverMeets) {
  Advice::Options options = quick(1e-2);
  options.time_limit = 1e-3;
  const Advice advice = advise(lattice(), options);
  EXPECT_EQ(advice.status, Advice::Status::kUndecided);
  EXPECT_TRUE(says(advice.message, "--time-limit 0.004"));
  EXPECT_FALSE(says(advice.message, "no solver meets")) << advice.message;
  // An accuracy needs no advice, where the scene takes one.
  Scene<2> scene = lattice();
  options.goal = {.penetration = 0.03};
  EXPECT_TRUE(says(advice_summary(advise(scene, options)), "--accuracy 0.01"));
  Scene<2> wide = scene;  // `bipot run` keeps a distance of the scene's own
  wide.contact_distance = 0.1 * smallest_radius(scene);
  scene.impact = ContactLaw::Impact::kFremond;
  for (const Scene<2>& refusing : {scene, wide}) {
    EXPECT_FALSE(says(advice_summary(advise(refusing, options)), "--accuracy"));
  }
}

/// Disks of 1 kg fall one by one from an inlet on a floor and leave at its end.
Scene<2> stream() {
  return scene_of(
      R"(
contact = {mu = 0.3}
walls = [{name = "slope", point = [0, 0], normal = [0.5, 0.8660254037844386]}]
outlets = [{name = "below", point = [0, -2], normal = [0, 1]}]
time = {step = 2e-3, steps = 600}
)"
      "inlets = [{name = 'above', lower = [-0.2, 0.4], upper = [0.2, 0.6], velocity = [0, -1], rate = 20, "
      "radii = [0.05], density = 100}]\n");
}

TEST(Advise, TakesBodiesThatComeAndGo) {
  const Advice advice = advise(stream(), quick(Accuracy{.load = 5e-2}));
  EXPECT_NE(advice.status, Advice::Status::kNoContacts) << advice.message;
  ASSERT_FALSE(advice.trials.empty());
  EXPECT_TRUE(std::isfinite(advice.trials[0].error.error.load));
}

TEST(Advise, TakesSpheres) {
  const AnyScene scene = read_any_scene(find_scene("four_spheres"));
  Advice::Options options = quick(Accuracy{.load = 1e-2});
  options.solvers = {{"auto", "auto", {}}, {"pgs", "pgs", {}}};
  Scene<3> spheres = std::get<Scene<3>>(scene);
  spheres.num_steps = 60;
  const Advice advice = advise(spheres, options);
  EXPECT_EQ(advice.status, Advice::Status::kMet) << advice.message;
  EXPECT_LE(expected_error(advice).bound().load, 1e-2);
}

/// The drum of a visitor, shortened: 40 of 150 disks, 0.1 of 2 s.
TEST(Advise, TheDrumIsNotAskedForDigitsThatExactRunsDoNotShare) {
  const Scene<2> drum = scene_of(
      R"(
contact = {mu = 0.5}
walls = [{center = [0, 0], radius = 0.15, hollow = true, spin = 1}]
time = {step = 2e-4, steps = 500}
)"
      "disks = [{arrangement = 'random', count = 40, radii = [0.004, 0.005, 0.006], width = 0.1, "
      "corner = [-0.05, -0.12], density = 2000}]\n");
  Advice::Options options;
  options.goal = {.energy = 5e-2};
  options.time_limit = 60;
  options.solvers = {{"auto", "auto", {}}, {"apgd", "apgd", {}}};
  const Advice advice = advise(drum, options);
  ASSERT_GE(advice.choice, 0) << advice.message;
  const Advice::SolverTrial& chosen = advice.trials[to_size(advice.choice)];
  if (chosen.verdict != Advice::SolverTrial::Verdict::kMissed) {
    EXPECT_TRUE(meets(chosen, advice.budget, advice.spread));
    // No tolerance a hundred times tighter than the loosest that meets.
    for (const Advice::SolverTrial& t : advice.trials) {
      if (t.solver.label == chosen.solver.label && meets(t, advice.budget, advice.spread)) {
        EXPECT_GE(chosen.tol, 0.05 * t.tol);
      }
    }
  }
}

TEST(Advise, TakesClusters) {
  // Dumbbells that fall on a floor: the force on a body is that on the whole cluster.
  for (const double mu : {0.0, 0.3}) {
    Scene<2> scene = scene_of(fmt::format(R"(
contact = {{mu = {}}}
walls = [{{point = [0, 0.07], normal = [0, 1]}}]
time = {{step = 1e-3, steps = 60}}
[[clusters]]
arrangement = "rectangular"
parts = [[0, 0, 0.1], [0.15, 0, 0.1]]
columns = 2
rows = 2
density = 100
)",
                                          mu));
    const Advice advice = advise(scene, quick(1e-1));
    EXPECT_NE(advice.status, Advice::Status::kInterrupted) << advice.message;
    ASSERT_FALSE(advice.trials.empty());
    bool measured = false;
    for (const Advice::SolverTrial& trial : advice.trials) {
      measured = measured || std::isfinite(trial.error.error.force);
    }
    EXPECT_TRUE(measured) << mu;
  }
}

TEST(RunSetting, AnInterruptedRunSaysWhereItEnded) {
  const Scene<2> scene = lattice();
  State<2> state = initial_state(scene);
  int steps = 0;
  const RunRecord run = run_setting(
      scene, state, {.solver = "auto", .tol = 1e-4}, {.cancelled = [&] { return steps >= 3; }},
      {.before_step = {}, .on_step = [&](const auto&) { return ++steps < 3; }});
  EXPECT_EQ(run.status, "interrupted");
  EXPECT_EQ(run.message, "after 3 of 40 steps");
}

TEST(Advise, EndsWhenInterrupted) {
  Advice::Options options = quick(1e-2);
  options.interrupted = [] { return true; };
  EXPECT_EQ(advise(lattice(), options).status, Advice::Status::kInterrupted);
}

}  // namespace
}  // namespace bipot
