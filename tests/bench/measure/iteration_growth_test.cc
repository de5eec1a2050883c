#include "bench/measure/iteration_growth.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(IterationGrowth, SideIsTheNearest) {
  EXPECT_EQ(side_of("square", 100), 10);
  EXPECT_EQ(side_of("square", 109), 10);  // 100 or 121
  EXPECT_EQ(side_of("square", 112), 11);
  EXPECT_EQ(side_of("pyramid", 55), 10);
  EXPECT_EQ(side_of("triangular", 95), 10);  // 5 rows of 10 and 5 of 9
  EXPECT_EQ(side_of("square", 1), 1);
  for (const char* family : {"square", "triangular", "pyramid"}) {
    const GrowthScene::Problem problem = make_growth_problem({.family = family}, 7);
    EXPECT_EQ(side_of(family, static_cast<double>(problem.bodies)), 7) << family;
  }
  EXPECT_THROW(make_growth_problem({.family = "simplex"}, 3), std::invalid_argument);
}

TEST(IterationGrowth, DilutedLatticeLacksATenthOfItsDisks) {
  const GrowthScene::Problem some = make_growth_problem({.family = "diluted", .seed = 1}, 40);
  const GrowthScene::Problem other = make_growth_problem({.family = "diluted", .seed = 2}, 40);
  // 1580 places, each empty with probability 1/10: 1422 ± 12 disks, four standard deviations.
  EXPECT_NEAR(static_cast<double>(some.bodies), 1422, 48);
  EXPECT_NE(some.problem.num_contacts(), other.problem.num_contacts());
}

// One solve with a history and a solve for each tolerance must say the same.
TEST(IterationGrowth, OneSolveGivesTheRowsOfAllTolerances) {
  const GrowthScene scene{.family = "triangular", .tilt_degrees = 10};
  const GrowthScene::Problem problem = make_growth_problem(scene, 8);
  const double tols[] = {1e-2, 1e-4, 1e-8};
  for (const SolverVariant& method :
       {SolverVariant{"u", "uzawa", {{"rho", "stable"}}}, SolverVariant{"p", "pgs"},
        SolverVariant{"a", "apgd"}, SolverVariant{"i", "ipm"}, SolverVariant{"n", "auto"}}) {
    const auto rows = growth_rows(scene, problem, method, tols, {});
    ASSERT_EQ(rows.size(), 3u);
    for (std::size_t k = 0; k < 3; ++k) {
      const GrowthRow alone = growth_row(scene, problem, method, tols[k], {});
      EXPECT_EQ(alone.status, rows[k].status);
      EXPECT_EQ(alone.iterations, rows[k].iterations) << method.solver << " " << tols[k];
      EXPECT_NEAR(alone.error.guarded() / rows[k].error.guarded(), 1, 1e-6) << method.solver;
      EXPECT_LE(rows[k].error.guarded(), tols[k]);
      EXPECT_GE(rows[k].solve_seconds, 0);
    }
  }
}

TEST(IterationGrowth, LimitLeavesTheTightRowsUnmet) {
  const GrowthScene scene{.family = "square"};
  const GrowthScene::Problem problem = make_growth_problem(scene, 10);
  const double tols[] = {1e-2, 1e-8};
  const auto rows = growth_rows(scene, problem, {"pgs", "pgs"}, tols, {.max_iterations = 400});
  EXPECT_EQ(rows[0].status, SolveStatus::kConverged);
  EXPECT_EQ(rows[1].status, SolveStatus::kIterationLimit);
  EXPECT_EQ(rows[1].iterations, 400);
  EXPECT_GT(rows[1].error.guarded(), 1e-8);
}

// 3 N² on five sizes, one of them too small and one unmet: exponent 2 without spread.
TEST(IterationGrowth, FitLeavesOutSmallAndUnmetRows) {
  std::vector<GrowthRow> rows;
  for (const int disks : {10, 300, 1000, 3000, 10000}) {
    GrowthRow row{.family = "square",
                  .method = "pgs",
                  .tol = 1e-4,
                  .bodies = static_cast<std::size_t>(disks),
                  .status = disks == 10000 ? SolveStatus::kTimeLimit : SolveStatus::kConverged,
                  .iterations = disks == 10 ? 1 : 3 * disks * disks,
                  .solve_seconds = static_cast<double>(disks)};
    rows.push_back(row);
    rows.push_back(row);  // measured again: counts once
  }
  const auto fits = fit_growth(rows, 300);
  ASSERT_EQ(fits.size(), 1u);
  EXPECT_EQ(fits[0].iterations.points, 3);
  EXPECT_NEAR(fits[0].iterations.exponent, 2, 1e-12);
  EXPECT_NEAR(fits[0].iterations.confidence, 0, 1e-6);
  EXPECT_NEAR(fits[0].seconds.exponent, 1, 1e-12);
  EXPECT_EQ(fits[0].not_met, 1);
  EXPECT_EQ(to_text(fits[0].iterations), "2.00 ± 0.00 (3 points)");
  EXPECT_EQ(to_text(PowerLaw{}), "– (0 points)");
}

}  // namespace
}  // namespace bipot
