#include "solvers/methods/auto_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "core/files/problem_file.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

ContactProblem shipped(const char* name) {
  return read_problem(std::filesystem::path(BIPOT_SOURCE_DIR) / "data/problems" / name).problem;
}

std::vector<AutoStage> plan(const ContactProblem& p, bool warm = false) {
  return plan_auto(p, DelassusOperator(p), warm);
}

TEST(AutoSolver, ExplainsEveryStageInALine) {
  const ContactProblem p = shipped("2d_pyramid_10.hdf5");
  const std::string text = explain_auto(p, {});
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'),
            static_cast<std::ptrdiff_t>(plan(p).size()) + 1);
  EXPECT_NE(text.find("145 contacts"), std::string::npos);
}

TEST(AutoSolver, UnequalMassesBeginWithFactorisations) {
  EXPECT_EQ(plan(shipped("2d_triangular_12_mass1e6.hdf5")).front().solver, "ipm");
  EXPECT_NE(plan(shipped("2d_triangular_lattice.hdf5")).front().solver, "ipm");
}

TEST(AutoSolver, GivesUpWhatDoesNotPromiseAndSolvesAllTheSame) {
  // Anderson and apgd do not get this pyramid to 1e-8 within 30 000 and 170 000 iterations.
  const SolveResult result = solve("auto", shipped("2d_pyramid_10.hdf5"), {.tol = 1e-8});
  EXPECT_EQ(result.status, SolveStatus::kConverged) << result.message;
  EXPECT_LE(result.error.guarded(), 1e-8);
  EXPECT_NE(result.message.find("anderson 16: given up"), std::string::npos) << result.message;
  EXPECT_LT(result.iterations, 20000);
}

TEST(AutoSolver, TheCallersCancelIsNoGivingUp) {
  int asked = 0;
  SolverOptions options{.tol = 1e-8};
  options.cancelled = [&asked] { return ++asked > 5; };
  const SolveResult result = solve("auto", shipped("2d_pyramid_10.hdf5"), options);
  EXPECT_EQ(result.status, SolveStatus::kInterrupted);
  EXPECT_LT(asked, 20);  // no further stage was begun
}

TEST(AutoSolver, TheIterationLimitHoldsForAllStagesTogether) {
  const SolveResult result =
      solve("auto", shipped("2d_pyramid_10.hdf5"), {.tol = 1e-8, .max_iterations = 30});
  EXPECT_EQ(result.status, SolveStatus::kIterationLimit) << result.message;
  EXPECT_LE(result.iterations, 30);
}

TEST(AutoSolver, HistoryCountsOnOverTheStages) {
  std::vector<int> iterations;
  SolverOptions options{.tol = 1e-8};
  options.on_iteration = [&](const IterationRecord& r) { iterations.push_back(r.iteration); };
  const SolveResult result = solve("auto", shipped("2d_pyramid_10.hdf5"), options);
  ASSERT_FALSE(iterations.empty());
  EXPECT_TRUE(std::is_sorted(iterations.begin(), iterations.end()));
  EXPECT_EQ(iterations.back(), result.iterations);
}

}  // namespace
}  // namespace bipot
