#include "bench/scenes/scene_run.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "bench/scenes/run_folder.h"
#include "core/files/fclib_file.h"
#include "core/files/run_reader.h"
#include "core/scene/scene_family.h"
#include "solvers/registry.h"
#include "solvers/step_solver.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// Disks that fall onto a floor and into each other.
Scene falling_disks(int steps) {
  Scene scene = make_family_scene("random", 4);
  scene.num_steps = steps;
  scene.solver.name = "apgd";
  scene.solver.tol = 1e-6;
  return scene;
}

TEST(SceneRun, TakesTheScenesStepsWithItsOwnSolver) {
  const Scene scene = falling_disks(40);
  State state = initial_state(scene);
  int seen = 0;
  SceneRunOptions options;
  options.on_step = [&](const SceneStep& step) {
    EXPECT_EQ(step.report.step, ++seen);
    EXPECT_EQ(step.state.step, seen);
    EXPECT_EQ(step.problem.num_contacts(), step.report.contacts);
    return true;
  };
  const SceneRun run = run_scene(scene, state, options);
  EXPECT_EQ(run.end, SceneRun::End::kCompleted);
  EXPECT_EQ(seen, 40);
  EXPECT_EQ(run.planned, 40);
  EXPECT_EQ(run.totals.steps, 40);
  EXPECT_EQ(run.totals.converged, 40);
  EXPECT_EQ(run.totals.last.step, 40);
  EXPECT_GT(run.totals.max_contacts, 0);
  EXPECT_LE(run.totals.worst.guarded(), 1e-6);
  EXPECT_EQ(state.step, 40);
}

TEST(SceneRun, InTwoPartsIsTheSameBitForBit) {
  const Scene scene = falling_disks(60);
  State whole = initial_state(scene);
  run_scene(scene, whole);
  State parts = initial_state(scene);
  run_scene(scene, parts, {.steps = 37});
  EXPECT_EQ(parts.step, 37);
  run_scene(scene, parts, {.steps = 23});
  EXPECT_EQ(parts.time, whole.time);
  for (std::size_t i = 0; i < whole.disks.size(); ++i) {
    EXPECT_EQ(whole.disks[i].x, parts.disks[i].x);
    EXPECT_EQ(whole.disks[i].v, parts.disks[i].v);
  }
}

TEST(SceneRun, EndsWhereAnOnlookerOrACallerSaysSo) {
  const Scene scene = falling_disks(40);
  State state = initial_state(scene);
  SceneRunOptions options;
  options.on_step = [](const SceneStep& step) { return step.report.step < 7; };
  EXPECT_EQ(run_scene(scene, state, options).end, SceneRun::End::kStopped);
  EXPECT_EQ(state.step, 7);
  options.on_step = {};
  options.cancelled = [&] { return state.step == 9; };
  EXPECT_EQ(run_scene(scene, state, options).end, SceneRun::End::kCancelled);
  EXPECT_EQ(state.step, 9);
}

TEST(SceneRun, AStepThatFailsIsReportedWithItsProblemAndStart) {
  Scene scene = falling_disks(200);
  scene.solver.warm_start = true;
  SolverOptions options;
  options.tol = 1e-6;
  const StepSolver apgd = make_step_solver(*find_solver("apgd"), options);
  int with_contacts = 0;
  SceneRunOptions run_options;
  run_options.solver = [&](const ContactProblem& p, const Vector& start) {
    StepSolution solution = apgd(p, start);
    if (p.num_contacts() > 0 && ++with_contacts == 5) {
      solution.failed = true;
      solution.message = "broken on purpose";
    }
    return solution;
  };
  State state = initial_state(scene);
  const SceneRun run = run_scene(scene, state, run_options);
  EXPECT_EQ(run.end, SceneRun::End::kFailed);
  ASSERT_TRUE(run.failure.has_value());
  EXPECT_EQ(run.failure->kind, StepFailure::Kind::kNumerical);
  EXPECT_NE(std::string(run.failure->what()).find("broken on purpose"), std::string::npos);
  EXPECT_EQ(run.totals.steps, state.step);  // the failed one is not taken
  EXPECT_GT(run.failed_problem.num_contacts(), 0);
  EXPECT_EQ(run.failed_start.size(), run.failed_problem.num_rows());
}

TEST(SceneRun, TheStartIsWhatTheStepBeforeLeft) {
  Scene scene = falling_disks(300);
  scene.solver.warm_start = true;
  State state = initial_state(scene);
  bool carried = false;
  SceneRunOptions options;
  options.on_step = [&](const SceneStep& step) {
    EXPECT_EQ(step.start.size(), step.problem.num_rows());
    carried = carried || (step.start.size() > 0 && step.start.norm() > 0);
    return true;
  };
  run_scene(scene, state, options);
  EXPECT_TRUE(carried);
  scene.solver.warm_start = false;
  options.on_step = [](const SceneStep& step) {
    EXPECT_EQ(step.start.size(), 0);
    return true;
  };
  state = initial_state(scene);
  run_scene(scene, state, options);
}

TEST(SceneRun, SpringsRunThroughTheSameCall) {
  Scene scene = falling_disks(3);
  scene.model = Model::kSpringDashpot;
  State state = initial_state(scene);
  const SceneRun run = run_scene(scene, state);
  EXPECT_EQ(run.end, SceneRun::End::kCompleted);
  ASSERT_TRUE(run.springs.has_value());
  EXPECT_EQ(run.totals.last.iterations, run.springs->substeps);
}

TEST(SceneRun, AnUnknownSolverIsRefusedBeforeTheFirstStep) {
  Scene scene = falling_disks(3);
  scene.solver.name = "no_such_solver";
  State state = initial_state(scene);
  EXPECT_THROW(run_scene(scene, state), std::invalid_argument);
  EXPECT_EQ(state.step, 0);
}

TEST(RunFolder, HoldsTheRunsLastStateAndItsProblems) {
  const TemporaryFolder folder;
  const Scene scene = falling_disks(60);
  State state = initial_state(scene);
  RunFolderOptions options;
  options.folder = folder.path() / "run";
  options.problems = RunFolderOptions::Problems::kAll;
  const SceneRun run = run_scene_into(scene, state, {}, options);
  EXPECT_GT(run.output_seconds, 0);
  EXPECT_EQ(read_state(options.folder).step, 60);
  EXPECT_EQ(read_state(options.folder).disks[3].x, state.disks[3].x);
  const ProblemFile last = read_fclib(options.folder / "problems" / "step_000060.hdf5");
  EXPECT_EQ(last.problem.num_contacts(), run.totals.last.contacts);
}

}  // namespace
}  // namespace bipot
