#include "bench/experiments/warm_start_study.h"

#include <gtest/gtest.h>

#include "core/scene/scene_family.h"

namespace bipot {
namespace {

Scene<2> lattice_at_rest() {
  Scene<2> scene = make_family_scene("triangular", 4);
  scene.num_steps = 4;
  return scene;
}

WarmStartOptions sweeps(int every) {
  return WarmStartOptions{.solvers = {{"pgs", "pgs", {}}, {"ipm", "ipm", {}}},
                          .tol = 1e-6,
                          .run_tol = 1e-9,
                          .every = every};
}

TEST(WarmStartStudy, SecondStepAtRestStartsFromItsSolution) {
  const std::vector<WarmStartRow> rows = study_warm_start(lattice_at_rest(), sweeps(1));
  ASSERT_EQ(rows.size(), 8u);  // 4 steps, 2 solvers
  const WarmStartRow &first = rows[0], &second = rows[2];
  EXPECT_EQ(first.step, 1);
  EXPECT_EQ(first.carried, 0);  // nothing before the first step
  EXPECT_EQ(first.warm, first.cold);
  EXPECT_EQ(second.step, 2);
  EXPECT_EQ(second.solver, "pgs");
  EXPECT_GT(second.carried, second.contacts / 2);
  EXPECT_TRUE(second.cold_met && second.warm_met);
  EXPECT_EQ(second.cold, first.cold);  // the same step again
  EXPECT_EQ(second.warm, 0);           // its impulses are known to 1e-9, 1e-6 is asked for
}

TEST(WarmStartStudy, ComparesEachNthStep) {
  const std::vector<WarmStartRow> rows = study_warm_start(lattice_at_rest(), sweeps(2));
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].step, 2);
  EXPECT_EQ(rows[2].step, 4);
  EXPECT_NEAR(rows[2].time, 4 * 0.01, 1e-15);
}

TEST(WarmStartStudy, AnUnmetToleranceIsSaid) {
  WarmStartOptions options = sweeps(1);
  options.max_iterations = 3;
  const std::vector<WarmStartRow> rows = study_warm_start(lattice_at_rest(), options);
  EXPECT_FALSE(rows[0].cold_met);
  EXPECT_EQ(rows[0].cold, 3);
  EXPECT_TRUE(rows[2].warm_met);  // the run itself is not limited
}

}  // namespace
}  // namespace bipot
