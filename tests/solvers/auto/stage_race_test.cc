#include "solvers/auto/stage_race.h"

#include "tests/support/converged.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

/// A solver that follows a script on one contact, whose solution is s_n = 1: each iteration the
/// distance to it is multiplied by `factor`. Counts in strides, and keeps the starts.
struct Script {
  double factor = 1;
  int stride = 1;
  std::vector<double> starts = {};
};
SolverEntry scripted(const char* name, Script& script) {
  return {.name = name, .summary = "script", .run = [&script](SolveRun& run) {
            Vector s = run.start();
            script.starts.push_back(s[0]);
            for (int k = 0; !run.stop(k, s); k += script.stride) {
              s[0] = 1 + script.factor * (s[0] - 1);
            }
          }};
}

AutoStage stage_of(const SolverEntry& entry, int most) {
  return {{.reason = "script"}, &entry, most, most, most};
}

class StageRace : public ::testing::Test {
 protected:
  SolveResult race(const std::vector<AutoStage>& stages, const Vector& best = {}) {
    SolveRun run(problem_, options_);
    return race_stages(run, stages, best, [](const AutoStage&) { return true; });
  }
  const ContactProblem problem_ = one_contact_problem(2, 1, 1, 0.5, -1, Vector::Zero(1));
  SolverOptions options_{.tol = 1e-8};
  Script slow_{0.9}, other_{0.9}, still_{1}, quick_{0.01};
  const SolverEntry slow = scripted("slow", slow_), other = scripted("other", other_),
                    still = scripted("still", still_), quick = scripted("quick", quick_);
};

/// After five iterations from 0: s = 1 - 0.9^5.
TEST_F(StageRace, StagesStartWhereThePlanSays) {
  const double five = 1 - std::pow(0.9, 5);
  AutoStage caller = stage_of(other, 5), last = stage_of(other, 5), best = stage_of(still, 5);
  caller.start = AutoPlan::Row::Start::kCaller;
  last.start = AutoPlan::Row::Start::kLast;
  last.of_start = 0.5;
  best.start = AutoPlan::Row::Start::kBest;
  options_.s0 = Vector::Zero(2);
  options_.s0[0] = 0.2;
  race({stage_of(slow, 5), caller, last, best, stage_of(slow, 5)});
  // From 0.2: 0.8 times the distance from 0.
  const double first = 1 - 0.8 * (1 - five);
  ASSERT_EQ(slow_.starts.size(), 2u);
  ASSERT_EQ(other_.starts.size(), 2u);
  ASSERT_EQ(still_.starts.size(), 1u);
  EXPECT_NEAR(slow_.starts[0], 0.2, 1e-12);
  EXPECT_NEAR(slow_.starts[1], first, 1e-12);  // taken up
  EXPECT_NEAR(other_.starts[0], 0.2, 1e-12);
  EXPECT_NEAR(other_.starts[1], 0.5 * first, 1e-12);
  // The best one: five iterations from half of it.
  EXPECT_NEAR(still_.starts[0], 1 - (1 - five) * (1 - 0.5 * first), 1e-12);
}

TEST_F(StageRace, AStageWithoutGainIsGivenUpAndTheNextOneSolves) {
  AutoStage standing = stage_of(still, 1000);
  standing.min_iterations = 10;
  const SolveResult result =
      converged(race({standing, stage_of(quick, 100), stage_of(other, 100)}));
  EXPECT_TRUE(says(result.message, "still 1"));
  EXPECT_TRUE(says(result.message, "given up"));
  EXPECT_LT(result.iterations, 40);
  EXPECT_TRUE(other_.starts.empty());
  EXPECT_NEAR(result.s[0], 1, 1e-7);
}

/// 0.9^k has 88 iterations to 1e-4, which the forecast sees from the 10th on.
TEST_F(StageRace, AStageThatWillArriveIsLetGoOn) {
  options_.tol = 1e-3;
  AutoStage arriving = stage_of(slow, 400);
  arriving.min_iterations = 10;
  EXPECT_EQ(race({arriving}).status, SolveStatus::kConverged);
  arriving.max_iterations = 20;
  EXPECT_TRUE(says(race({arriving}).message, "given up"));
}

/// A decade takes 22 iterations of 0.9^k: within the last one a stage may take 1.25 of its budget.
TEST_F(StageRace, AStageThatIsNearIsGivenAQuarterMore) {
  const auto needed = [&] { return converged(race({stage_of(slow, 1000)})).iterations; };
  const auto ends_at = [&](int budget) {
    const std::string message = race({stage_of(slow, budget)}).message;
    EXPECT_TRUE(says(message, fmt::format("slow {}: iteration limit", budget)));
  };
  options_.tol = 1e-3;
  const int enough = static_cast<int>(std::ceil(needed() / 1.25));
  converged(race({stage_of(slow, enough)}));
  ends_at(enough - 5);
  options_.tol = 1e-8;
  ends_at(static_cast<int>(std::ceil(needed() / 1.25)));  // far
  slow_.stride = 7;
  EXPECT_TRUE(says(race({stage_of(slow, 40)}).message, "slow 42: iteration limit"));
  slow_.stride = 1;
  options_.tol = 1e-3;
  options_.s0 = Vector::Zero(2);
  options_.s0[0] = 1e-3;
  ends_at(enough);  // warm
}

TEST_F(StageRace, AStageWaitsForAnErrorThatIsSmallEnough) {
  AutoStage near = stage_of(quick, 100);
  near.largest_error = 1e-3;
  const SolveResult far = race({near, stage_of(still, 3)});
  EXPECT_TRUE(quick_.starts.empty());
  EXPECT_EQ(far.status, SolveStatus::kIterationLimit);
  Vector best = Vector::Zero(2);
  best[0] = 1 - 1e-6;
  EXPECT_EQ(race({near, stage_of(still, 3)}, best).status, SolveStatus::kConverged);
  EXPECT_EQ(quick_.starts.size(), 1u);
}

TEST_F(StageRace, WithoutStagesThereIsNoStatus) {
  EXPECT_EQ(race({}).status, SolveStatus::kNotRun);
  EXPECT_EQ(race({stage_of(still, 3)}).status, SolveStatus::kIterationLimit);
}

TEST_F(StageRace, TheIterationLimitHoldsForAllStages) {
  options_.max_iterations = 7;
  const SolveResult result = race({stage_of(still, 5), stage_of(slow, 5), stage_of(other, 5)});
  EXPECT_EQ(result.iterations, 7);
  EXPECT_TRUE(other_.starts.empty());
  EXPECT_EQ(result.status, SolveStatus::kIterationLimit);
}

}  // namespace
}  // namespace bipot
