#include "bench/experiments/stop_test_study.h"

#include "bench/measure/true_error.h"
#include "solvers/solve.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

StopTestRow met_row(const std::string& scene, double tol, double velocity) {
  return StopTestRow{
      .scene = scene, .solver = "pgs", .tol = tol, .met = true, .velocity = velocity};
}

TEST(StopTestPrediction, CountsAndAveragesErrorOverTolerance) {
  // error / tol is 2, 8 and 2, 50: geometric mean (2·8·2·50)^¼ = 1600^¼, one of them above 10.
  std::vector<StopTestRow> rows = {met_row("a", 1e-2, 2e-2), met_row("a", 1e-4, 8e-4),
                                   met_row("b", 1e-2, 2e-2), met_row("b", 1e-4, 50e-4)};
  rows.push_back(met_row("b", 1e-6, 1));
  rows.back().met = false;
  const Prediction p = predict(rows);
  EXPECT_EQ(p.asked, 5);
  EXPECT_EQ(p.met, 4);
  EXPECT_EQ(p.too_early, 1);
  EXPECT_EQ(p.too_late, 0);
  EXPECT_NEAR(p.factor, std::pow(1600, 0.25), 1e-12);
  EXPECT_NEAR(p.smallest, 2, 1e-12);
  EXPECT_NEAR(p.largest, 50, 1e-12);
  // Logarithms ln 2, ln 8, ln 2, ln 50 about their mean.
  const double m = std::log(1600) / 4;
  const double variance = (2 * std::pow(std::log(2) - m, 2) + std::pow(std::log(8) - m, 2) +
                           std::pow(std::log(50) - m, 2)) /
                          4;
  EXPECT_NEAR(p.spread, std::exp(std::sqrt(variance)), 1e-12);
  EXPECT_TRUE(std::isnan(p.slope));  // two met rows a scene: no slope
}

TEST(StopTestPrediction, SlopeIsTheMedianOverScenes) {
  std::vector<StopTestRow> rows;
  for (const std::string scene : {"a", "b"}) {
    for (const double tol : {1e-1, 1e-2, 1e-3, 1e-4}) {
      rows.push_back(met_row(scene, tol, scene == "a" ? 3 * tol : std::sqrt(tol)));
    }
  }
  EXPECT_NEAR(predict(rows).slope, 0.75, 1e-12);  // of 1 and ½
}

TEST(StopTestPrediction, ExactAnswersAreLateAndLeaveTheMeanAlone) {
  const Prediction p = predict({met_row("a", 1e-2, 0), met_row("a", 1e-3, 2e-3)});
  EXPECT_EQ(p.too_late, 1);
  EXPECT_NEAR(p.factor, 2, 1e-12);
}

TEST(StopTestStudy, RowsAreWhatASolveWithThatTestReturns) {
  StopTestScene scene{"t5", false, {}};
  scene.given.problem = lattice_step(Lattice::kTriangular, 5, 0.3, 10);
  const ReferenceSolution reference = find_reference(scene.given, 20);
  StopTestOptions options{
      .solvers = {{"sweeps", "pgs", {}}}, .tols = {1e-2, 1e-5}, .max_iterations = 5000};
  const std::vector<StopTestRow> rows = study_stop_tests(scene, reference, options);
  ASSERT_EQ(rows.size(), 6u);
  const TrueErrorEvaluator true_error(scene.given, reference);
  for (const StopTestRow& row : rows) {
    SolverOptions solver{
        .tol = row.tol, .stop = row.stop, .max_iterations = options.max_iterations};
    const SolveResult alone = solve("pgs", scene.given.problem, solver);
    EXPECT_EQ(row.met, is_success(alone.status)) << to_string(row.stop) << row.tol;
    EXPECT_EQ(row.iterations, alone.iterations);
    EXPECT_EQ(row.velocity, true_error(alone.s).velocity);
  }
  // The guarded test foretells its error; the difference of slow sweeps does not.
  for (const StopTestRow& row : rows) {
    if (row.stop == StopTest::kGuarded) {
      EXPECT_LE(row.velocity, row.tol);
    }
    if (row.stop == StopTest::kImpulse) {
      EXPECT_GT(row.velocity, 2 * row.tol);
    }
  }
}

TEST(StopTestStudy, WhatIsNotMetIsNotMetTighter) {
  StopTestScene scene{"s5", false, {}};
  scene.given.problem = lattice_step(Lattice::kSquare, 5, 0.3, 0);
  const ReferenceSolution reference = find_reference(scene.given, 20);
  StopTestOptions options{
      .solvers = {{"sweeps", "pgs", {}}}, .tols = {1e-1, 1e-6, 1e-8}, .max_iterations = 30};
  const std::vector<StopTestRow> rows = study_stop_tests(scene, reference, options);
  ASSERT_EQ(rows.size(), 9u);
  EXPECT_FALSE(rows[1].met);
  EXPECT_FALSE(rows[2].met);
  EXPECT_EQ(rows[2].tol, 1e-8);
  EXPECT_EQ(rows[2].velocity, rows[1].velocity);
}

}  // namespace
}  // namespace bipot
