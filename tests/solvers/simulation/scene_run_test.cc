#include "solvers/simulation/scene_run.h"

#include "core/motion/spring_dashpot_setup.h"
#include "core/problem_files/fclib_file.h"
#include "core/run_files/run_reader.h"
#include "core/scene/scene_family.h"
#include "core/scene/scene_parts.h"
#include "solvers/registry.h"
#include "solvers/simulation/run_folder.h"
#include "solvers/simulation/split_step.h"
#include "solvers/simulation/step_solver.h"
#include "tests/support/state_bits.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// Disks that fall onto a floor and into each other.
Scene<2> falling_disks(int steps) {
  Scene<2> scene = make_family_scene("random", 4);
  scene.num_steps = steps;
  scene.solver.name = "apgd";
  scene.solver.tol = 1e-6;
  return scene;
}

TEST(SceneRun, TakesTheScenesStepsWithItsOwnSolver) {
  const Scene<2> scene = falling_disks(40);
  State<2> state = initial_state(scene);
  int seen = 0;
  SceneRunOptions<2> options;
  options.on_step = [&](const SceneStep<2>& step) {
    EXPECT_EQ(step.report.step, ++seen);
    EXPECT_EQ(step.state.step, seen);
    EXPECT_EQ(step.problem.num_contacts(), step.report.contacts);
    return true;
  };
  const SceneRun<2> run = run_scene(scene, state, options);
  EXPECT_EQ(run.end, SceneRun<2>::End::kCompleted);
  EXPECT_EQ(seen, 40);
  EXPECT_EQ(run.planned, 40);
  EXPECT_EQ(run.totals.steps, 40);
  EXPECT_EQ(run.totals.converged, 40);
  EXPECT_EQ(run.totals.last.step, 40);
  EXPECT_GT(run.totals.max_contacts, 0);
  EXPECT_LE(run.totals.worst.guarded(), 1e-6);
  EXPECT_EQ(state.step, 40);
}

TEST(SceneRun, RefusesFaultyScenesAndStatesOfOthers) {
  const auto refused = [](const Scene<2>& scene, State<2> state) -> std::string {
    try {
      run_scene(scene, state);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return {};
  };
  const Scene<2> scene = falling_disks(2);
  const State<2> start = initial_state(scene);
  Scene<2> faulty = scene;
  faulty.bodies[0].material = 7;
  EXPECT_TRUE(says(refused(faulty, start), "material index 7"));
  State<2> other = start;
  other.bodies.pop_back();
  EXPECT_TRUE(says(refused(scene, other), "the state does not fit the scene: it has 15 disks"));
  other = start;
  other.walls.clear();
  EXPECT_TRUE(says(refused(scene, other), "0 walls"));
  other = start;
  other.bodies[0].material = 7;
  EXPECT_TRUE(says(refused(scene, other), "disk 0 has material 7"));
  other = start;
  other.clusters.bodies.emplace_back();
  EXPECT_TRUE(says(refused(scene, other), "1 clusters"));
  other = start;  // what a caller may change between runs
  other.bodies[0].mass *= 2;
  EXPECT_EQ(refused(scene, other), "");
}

TEST(SceneRun, NamesAPairOnlyWhereTheOverlapGrows) {
  const Scene<2> scene = falling_disks(40);
  State<2> state = initial_state(scene);
  SceneRunOptions<2> options;
  double most = 0;
  int named = 0;
  std::string pair;
  options.on_step = [&](const SceneStep<2>& step) {
    EXPECT_EQ(step.report.overlap_pair.empty(), step.report.overlap <= most);
    if (step.report.overlap > most) pair = step.report.overlap_pair;
    named += step.report.overlap > most ? 1 : 0;
    most = std::max(most, step.report.overlap);
    return true;
  };
  EXPECT_EQ(run_scene(scene, state, options).totals.overlap_pair, pair);
  EXPECT_GT(named, 0);
  EXPECT_LT(named, 30);
}

/// Two disks of 2 kg that reach a floor at 1 m/s in one step of 10 ms, 3 ms apart.
Scene<2> two_landings() {
  Scene<2> scene = one_law<2>({});
  scene.step = 0.01;
  scene.num_steps = 1;
  scene.walls = {flat_floor<2>()};
  scene.bodies = {round_body<2>(Vec2(0, 0.501), 0.5, 2, Vec2(0, -1)),
                  round_body<2>(Vec2(3, 0.504), 0.5, 2, Vec2(0, -1))};
  return scene;
}

/// Solves problems in which no more than `most` contacts close, and gives up on others.
StepSolver gives_up_beyond(int most) {
  return [most, solver = make_step_solver(require_solver("pgs"), {})](const ContactProblem& p,
                                                                      const Vector& s0) mutable {
    StepSolution solution = solver(p, s0);
    if ((p.u_free.array() < -1e-9).count() > most) {
      solution.converged = false;
      solution.message = "too many at once";
    }
    return solution;
  };
}

TEST(SceneRun, AStepThatIsNotSolvedIsTakenInPartsThatAddUp) {
  const Scene<2> scene = two_landings();
  State<2> state = initial_state(scene);
  SceneRunOptions<2> options{.solver = gives_up_beyond(1), .on_failure = OnFailure::kSmallerStep};
  const SceneRun<2> run = run_scene(scene, state, options);
  ASSERT_EQ(run.end, SceneRun<2>::End::kCompleted);
  EXPECT_EQ(run.totals.split, 1);
  EXPECT_EQ(run.totals.converged, 1);
  EXPECT_EQ(state.step, 1);
  EXPECT_EQ(state.time, 0.01);
  // Both stop: each contact's impulses of all parts are m v = 2 N s, and 2 J of shocks are lost.
  ASSERT_EQ(state.contacts.size(), 2u);
  for (const ContactOutcome<2>& c : state.contacts) EXPECT_NEAR(c.s_n, 2, 1e-9);
  EXPECT_NEAR(state.shock_loss, 2, 1e-9);
  EXPECT_NEAR(run.totals.last.energy.imbalance, 0, 1e-12);
  EXPECT_NEAR(run.totals.last.momentum_imbalance.norm(), 0, 1e-12);
  // The first part stops disk 0 alone; disk 1 has gone half of the step further by then.
  EXPECT_LT(state.bodies[1].x[1] - 0.5, state.bodies[0].x[1] - 0.5 + 0.003);
}

/// One step, not solved whole nor in its first half: what those attempts took is counted with the
/// parts.
TEST(SceneRun, IterationsOfAttemptsThatWereNotTakenCount) {
  const Scene<2> scene = two_landings();
  State<2> state = initial_state(scene);
  int calls = 0;
  SceneRunOptions<2> options;
  options.solver = [&, solver = gives_up_beyond(0)](const ContactProblem& p, const Vector& s0) {
    StepSolution solution = solver(p, s0);
    solution.iterations = 10;
    solution.converged = ++calls > 2;
    return solution;
  };
  options.on_failure = OnFailure::kSmallerStep;
  const SceneRun<2> run = run_scene(scene, state, options);
  ASSERT_EQ(run.end, SceneRun<2>::End::kCompleted);
  EXPECT_EQ(calls, 5);  // whole, half, two quarters, half
  EXPECT_EQ(run.totals.last.iterations, 50);
}

/// A disk at rest, m g = 20 N, in steps of 0.01 s. Problems of more than 0.004 s are given up, so
/// that each step takes four quarters, of 0.05 N s each.
struct RestingDisk {
  Scene<2> scene = one_law<2>({});
  std::vector<double> starts;  // s_n, of each solve
  int iterations = 0;          // of each solve

  RestingDisk() {
    scene.gravity = Vec2(0, -10);
    scene.step = 0.01;
    scene.walls = {flat_floor<2>()};
    scene.bodies = {round_body<2>(Vec2(0, 0.5), 0.5, 2)};
  }
  SceneRun<2> run(State<2>& state, int steps, RunFolderOptions folder = {}) {
    scene.num_steps = steps;
    SceneRunOptions<2> options{.on_failure = OnFailure::kSmallerStep, .folder = std::move(folder)};
    options.solver = [this, solver = make_step_solver(require_solver("pgs"), {})](
                         const ContactProblem& p, const Vector& s0) {
      StepSolution solution = solver(p, s0);
      starts.push_back(s0.size() > 0 ? s0[0] : 0.0);
      solution.iterations = iterations;
      solution.converged = p.u_free[0] > -0.04;  // -g h
      return solution;
    };
    return run_scene(scene, state, options);
  }
};

TEST(SceneRun, AStepBeginsWithAsManyPartsAsTheOneBefore) {
  RestingDisk disk;
  disk.iterations = kAttemptIterations;
  State<2> state = initial_state(disk.scene);
  ASSERT_EQ(disk.run(state, 2).totals.converged, 2);
  // Whole, half, two quarters, half, two quarters; then four quarters.
  ASSERT_EQ(disk.starts.size(), 11u);
  EXPECT_EQ(state.halvings, 2);
  EXPECT_NEAR(state.contacts[0].s_n, 0.2, 1e-8);
  // The impulses of a step begin the next, in proportion to the lengths.
  for (std::size_t k = 7; k < 11; ++k) EXPECT_NEAR(disk.starts[k], 0.05, 1e-8) << k;
}

TEST(SceneRun, AfterEasyPartsFewerAreTried) {
  RestingDisk disk;
  disk.iterations = 10;
  State<2> state = initial_state(disk.scene);
  ASSERT_EQ(disk.run(state, 2).totals.converged, 2);
  // Seven as above; then half, two quarters, half, two quarters.
  EXPECT_EQ(disk.starts.size(), 13u);
  EXPECT_EQ(state.halvings, 1);
  EXPECT_NEAR(disk.starts[7], 0.1, 1e-8);
}

TEST(SceneRun, ARestartBeginsWithThePartsOfTheLastStep) {
  const TemporaryFolder folder;
  RestingDisk disk;
  disk.iterations = kAttemptIterations;
  State<2> state = initial_state(disk.scene);
  disk.run(state, 1, {.folder = folder.path() / "run"});
  State<2> read = read_state(folder.path() / "run");
  EXPECT_EQ(read.halvings, 2);
  disk.starts.clear();
  ASSERT_EQ(disk.run(read, 1).totals.converged, 1);
  EXPECT_EQ(disk.starts.size(), 4u);
  // Other runs forget them.
  run_scene(disk.scene, read, {.steps = 1});
  EXPECT_EQ(read.halvings, 0);
}

/// Each sweep takes a thousandth of the error off: to 1e-8 it needs some 18 000.
TEST(SceneRun, WhereAStepMayBeCutTheScenesSolverHasFewIterationsByDefault) {
  RestingDisk disk;
  disk.scene.num_steps = 1;
  disk.scene.solver.name = "pgs";
  disk.scene.solver.parameters = {{"omega", "0.001"}};
  const auto run = [&](OnFailure what) {
    State<2> state = initial_state(disk.scene);
    return run_scene(disk.scene, state, {.on_failure = what});
  };
  const SceneRun<2> cut = run(OnFailure::kSmallerStep);
  EXPECT_EQ(cut.end, SceneRun<2>::End::kFailed);
  EXPECT_TRUE(says(cut.failure->what(), fmt::format("iteration limit {}", kAttemptIterations)));
  EXPECT_EQ(run(OnFailure::kStop).totals.converged, 1);
  disk.scene.solver.limits_iterations = true;  // the same number, given by the scene
  EXPECT_EQ(run(OnFailure::kSmallerStep).totals.converged, 1);
  disk.scene.solver.limits_iterations = false;
  disk.scene.solver.max_iterations = 100000;
  EXPECT_EQ(run(OnFailure::kSmallerStep).totals.split, 0);
  EXPECT_EQ(run(OnFailure::kSmallerStep).totals.converged, 1);
}

TEST(SceneRun, AStepThatIsNotSolvedEndsTheRunOnRequest) {
  const Scene<2> scene = two_landings();
  for (const OnFailure what : {OnFailure::kStop, OnFailure::kSmallerStep}) {
    State<2> state = initial_state(scene);
    SceneRunOptions<2> options{.solver = gives_up_beyond(what == OnFailure::kStop ? 1 : 0),
                               .on_failure = what};
    const SceneRun<2> run = run_scene(scene, state, options);
    EXPECT_EQ(run.end, SceneRun<2>::End::kFailed);
    ASSERT_TRUE(run.failure.has_value());
    EXPECT_EQ(run.failure->kind, StepFailure::Kind::kNotConverged);
    EXPECT_TRUE(says(run.failure->what(), "too many at once"));
    EXPECT_EQ(run.failed_problem.num_contacts(), 2);
    EXPECT_EQ(state.step, 0);
    EXPECT_EQ(state.bodies[0].x, scene.bodies[0].x);
  }
  // Without the request it is taken, and said.
  State<2> state = initial_state(scene);
  SceneRunOptions<2> options{.solver = gives_up_beyond(1)};
  const SceneRun<2> run = run_scene(scene, state, options);
  EXPECT_EQ(run.end, SceneRun<2>::End::kCompleted);
  EXPECT_EQ(run.totals.converged, 0);
  EXPECT_EQ(run.totals.split, 0);
}

TEST(SceneRun, InTwoPartsIsTheSameBitForBit) {
  const Scene<2> scene = falling_disks(60);
  State<2> whole = initial_state(scene);
  run_scene(scene, whole);
  State<2> parts = initial_state(scene);
  run_scene(scene, parts, {.steps = 37});
  EXPECT_EQ(parts.step, 37);
  run_scene(scene, parts, {.steps = 23});
  EXPECT_EQ(parts.time, whole.time);
  EXPECT_EQ(bits_of_bodies(whole), bits_of_bodies(parts));
}

TEST(SceneRun, EndsWhereAnOnlookerOrACallerSaysSo) {
  const Scene<2> scene = falling_disks(40);
  State<2> state = initial_state(scene);
  SceneRunOptions<2> options{
      .on_step = [](const SceneStep<2>& step) { return step.report.step < 7; }};
  EXPECT_EQ(run_scene(scene, state, options).end, SceneRun<2>::End::kStopped);
  EXPECT_EQ(state.step, 7);
  options.on_step = {};
  options.cancelled = [&] { return state.step == 9; };
  EXPECT_EQ(run_scene(scene, state, options).end, SceneRun<2>::End::kCancelled);
  EXPECT_EQ(state.step, 9);
}

TEST(SceneRun, AStepThatFailsIsReportedWithItsProblemAndStart) {
  Scene<2> scene = falling_disks(200);
  scene.solver.warm_start = true;
  const StepSolver apgd = make_step_solver(*find_solver("apgd"), {.tol = 1e-6});
  int with_contacts = 0;
  SceneRunOptions<2> run_options;
  run_options.solver = [&](const ContactProblem& p, const Vector& start) {
    StepSolution solution = apgd(p, start);
    if (p.num_contacts() > 0 && ++with_contacts == 5) {
      solution.failed = true;
      solution.message = "broken on purpose";
    }
    return solution;
  };
  State<2> state = initial_state(scene);
  const SceneRun<2> run = run_scene(scene, state, run_options);
  EXPECT_EQ(run.end, SceneRun<2>::End::kFailed);
  ASSERT_TRUE(run.failure.has_value());
  EXPECT_EQ(run.failure->kind, StepFailure::Kind::kNumerical);
  EXPECT_TRUE(says(run.failure->what(), "broken on purpose"));
  EXPECT_EQ(run.totals.steps, state.step);  // the failed one is not taken
  EXPECT_GT(run.failed_problem.num_contacts(), 0);
  EXPECT_EQ(run.failed_start.size(), run.failed_problem.num_rows());
}

TEST(SceneRun, TheStartIsWhatTheStepBeforeLeft) {
  Scene<2> scene = falling_disks(300);
  scene.solver.warm_start = true;
  State<2> state = initial_state(scene);
  bool carried = false;
  SceneRunOptions<2> options;
  options.on_step = [&](const SceneStep<2>& step) {
    EXPECT_EQ(step.start.size(), step.problem.num_rows());
    carried = carried || (step.start.size() > 0 && step.start.norm() > 0);
    return true;
  };
  run_scene(scene, state, options);
  EXPECT_TRUE(carried);
  scene.solver.warm_start = false;
  options.on_step = [](const SceneStep<2>& step) {
    EXPECT_EQ(step.start.size(), 0);
    return true;
  };
  state = initial_state(scene);
  run_scene(scene, state, options);
}

/// A disk comes down at 1 m/s, 5 mm in each half of a step. In the second half of step 20 its middle
/// would be 2 mm in the floor.
Scene<2> landing_in_the_last_part() {
  Scene<2> scene = two_landings();
  scene.bodies = {round_body<2>(Vec2(0, 0.2455), 0.05, 2, Vec2(0, -1))};
  scene.travel = 0.1;
  scene.num_steps = 20;
  return scene;
}

TEST(SceneRun, AStepThatIsCutHasTheProblemOfItsLastPart) {
  const Scene<2> scene = landing_in_the_last_part();
  State<2> state = initial_state(scene);
  SceneRunOptions<2> options;
  options.on_step = [&](const SceneStep<2>& step) {
    EXPECT_TRUE(step.cut);
    EXPECT_EQ(step.problem.num_contacts(), step.report.step == 20 ? 1 : 0) << step.report.step;
    if (step.report.step == 20) {
      EXPECT_NEAR(step.problem.u_free[0], -1, 1e-12);
    }
    return true;
  };
  EXPECT_EQ(run_scene(scene, state, options).totals.converged, 20);
  EXPECT_NEAR(state.bodies[0].v[1], 0, 1e-12);
}

TEST(SceneRun, AFailureInAPartNamesTheWholeStep) {
  const Scene<2> scene = landing_in_the_last_part();
  State<2> state = initial_state(scene);
  const SceneRun<2> run =
      run_scene(scene, state, {.solver = gives_up_beyond(0), .on_failure = OnFailure::kStop});
  EXPECT_EQ(run.end, SceneRun<2>::End::kFailed);
  EXPECT_EQ(state.step, 19);
  ASSERT_TRUE(run.failure.has_value());
  EXPECT_TRUE(says(run.failure->what(), "step 20 at t = ")) << run.failure->what();
}

TEST(SceneRun, ItsPlanIsReadOnce) {
  const TemporaryFolder folder;
  const auto plan = folder / "plan.toml";
  std::ofstream(plan) << "[[class]]\nname = \"all\"\nstages = [{solver = \"pgs\"}]\n";
  Scene<2> scene = falling_disks(20);
  scene.solver = {.name = "auto", .tol = 1e-4, .parameters = {{"plan", plan.string()}}};
  SceneRunOptions<2> options;
  options.on_step = [&](const SceneStep<2>&) {
    fs::remove(plan);
    return true;
  };
  State<2> state = initial_state(scene);
  EXPECT_EQ(run_scene(scene, state, options).totals.converged, 20);
  EXPECT_THROW(run_scene(scene, state, options), FileError);  // before the first step
}

TEST(SceneRun, SpringsRunThroughTheSameCall) {
  Scene<2> scene = falling_disks(3);
  scene.model = Model::kSpringDashpot;
  State<2> state = initial_state(scene);
  const SceneRun<2> run = run_scene(scene, state);
  EXPECT_EQ(run.end, SceneRun<2>::End::kCompleted);
  ASSERT_NE(run.springs, nullptr);
  EXPECT_EQ(run.totals.last.iterations, run.springs->substeps);
}

TEST(SceneRun, AnUnknownSolverIsRefusedBeforeTheFirstStep) {
  Scene<2> scene = falling_disks(3);
  scene.solver.name = "no_such_solver";
  State<2> state = initial_state(scene);
  EXPECT_THROW(run_scene(scene, state), std::invalid_argument);
  EXPECT_EQ(state.step, 0);
}

TEST(RunFolder, HoldsTheRunsLastStateAndItsProblems) {
  const TemporaryFolder folder;
  const Scene<2> scene = falling_disks(60);
  State<2> state = initial_state(scene);
  RunFolderOptions options{.folder = folder.path() / "run",
                           .problems = RunFolderOptions::Problems::kAll};
  const SceneRun<2> run = run_scene(scene, state, {.folder = options});
  EXPECT_GT(run.output_seconds, 0);
  EXPECT_EQ(read_state(options.folder).step, 60);
  EXPECT_EQ(read_state(options.folder).bodies[3].x, state.bodies[3].x);
  const ProblemFile last = read_fclib(options.folder / "problems" / "step_000060.hdf5");
  EXPECT_EQ(last.problem.num_contacts(), run.totals.last.contacts);
}

// At the end of step 20 the disk has fallen below 0, half-way through step 20 it has not.
TEST(SplitStep, LetsBodiesLeaveOnceAStep) {
  Scene<2> scene = one_law<2>({});
  scene.gravity = Vec2(0, -10);
  scene.step = 0.01;
  scene.bodies = {round_body<2>(Vec2(0, 0.2 - 1e-6), 0.05, 2), round_body<2>(Vec2(1, 9), 0.05, 2)};
  scene.outlets.resize(1);  // below y = 0
  const StepSolver sweeps = make_step_solver(*find_solver("pgs"), {});
  State<2> state = initial_state(scene);
  for (int k = 0; k < 21; ++k) {
    const SplitStep<2> split = advance_in_parts<2>(
        scene, {.solver = sweeps, .on_failure = OnFailure::kSmallerStep}, state, 1, kMostHalvings);
    EXPECT_EQ(split.parts, 2);
    EXPECT_EQ(state.bodies.size(), state.step < 21 ? 2u : 1u) << state.step;
  }
  EXPECT_EQ(state.population.outlets[0].count, 1);
  EXPECT_EQ(state.population.outlets[0].last_mass, 2);
  EXPECT_NEAR(state.bodies[0].x[1], 9 - 5 * 0.21 * 0.21, 1e-12);
}

}  // namespace
}  // namespace bipot
