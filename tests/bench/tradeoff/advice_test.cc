#include "bench/tradeoff/advice.h"

#include "bench/tradeoff/advice_verdict.h"
#include "core/base/types.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

Accuracy force(double x) { return {.force = x}; }

Advice::StepTrial step(double h, double error, double bar = 0) {
  return {h / 1e-3, h, {force(error), force(bar)}};
}

Advice::SolverTrial trial(const std::string& name, double tol, double error, double seconds) {
  Advice::SolverTrial t;
  t.solver = {name, name, {}};
  t.tol = tol;
  t.stretches = t.solved = 4;
  t.error.error = force(error);
  t.seconds = seconds;
  return t;
}

TEST(Advice, ShareIsTheWorstOfWhatIsAskedFor) {
  const Accuracy goal{.force = 1e-2, .energy = 1e-1};
  EXPECT_DOUBLE_EQ(share_of({.force = 5e-3, .penetration = 1, .energy = 2e-2}, goal), 0.5);
  EXPECT_DOUBLE_EQ(share_of({.force = 1e-3, .energy = 3e-1}, goal), 3);
  EXPECT_EQ(share_of({.penetration = 1}, goal), 0);  // not asked for
}

TEST(Advice, LargestStepThatTakesHalfTheGoal) {
  const std::vector<Advice::StepTrial> steps = {step(4e-3, 8e-3), step(2e-3, 4e-3),
                                                step(1e-3, 2e-3)};
  const Advice::StepChoice half = choose_step(steps, force(1e-2));
  EXPECT_EQ(half.index, 1);
  EXPECT_TRUE(half.met);
  // Half of 2.5e-3 is below all; nine tenths are not.
  const Advice::StepChoice most = choose_step(steps, force(2.5e-3));
  EXPECT_EQ(most.index, 2);
  EXPECT_TRUE(most.met);
}

TEST(Advice, AnAccuracyIsTakenWhereItIsCheaperOrNoEqualStepMeets) {
  std::vector<Advice::StepTrial> steps = {step(2e-3, 2e-2), step(1e-3, 4e-3), step(1e-2, 8e-3)};
  steps[1].seconds = 1;
  steps[2].accuracy = 0.1;
  for (const double seconds : {0.5, 2.0}) {
    steps[2].seconds = seconds;
    EXPECT_EQ(choose_step(steps, force(1e-2)).index, seconds < 1 ? 2 : 1);
  }
  // Of 8e-3 the equal steps take too much; of 1e-3 all do, and the least is named.
  steps[1].error.error = force(1.2e-2);
  EXPECT_EQ(choose_step(steps, force(1e-2)).index, 2);
  EXPECT_TRUE(choose_step(steps, force(1e-2)).met);
  EXPECT_EQ(choose_step(steps, force(1e-3)).index, 2);
  EXPECT_FALSE(choose_step(steps, force(1e-3)).met);
  steps[2].error.error = force(5e-2);
  EXPECT_EQ(choose_step(steps, force(1e-3)).index, 1);
}

TEST(Advice, AStepIsNoBetterThanASmallerOne) {
  const std::vector<Advice::StepTrial> steps = {step(4e-3, 1e-3), step(2e-3, 4e-2),
                                                step(1e-3, 2e-3)};
  const Advice::StepChoice choice = choose_step(steps, force(1e-2));
  EXPECT_EQ(choice.index, 2);  // 4e-3 s came out well by chance
  EXPECT_TRUE(choice.met);
}

TEST(Advice, TheBarCounts) {
  // 4e-3 ± 3e-3 may be 7e-3: within nine tenths of 1e-2, not within half of it.
  EXPECT_EQ(choose_step({step(2e-3, 4e-3, 3e-3), step(1e-3, 1e-3, 3e-3)}, force(1e-2)).index, 1);
  // A smaller step that may be as good as nothing says nothing against a larger one.
  const Advice::StepChoice choice =
      choose_step({step(2e-3, 4e-3), step(1e-3, 2e-2, 3e-2)}, force(1e-2));
  EXPECT_EQ(choice.index, 0);
  EXPECT_TRUE(choice.met);
  EXPECT_FALSE(choose_step({step(1e-3, 5e-3, 5e-3)}, force(1e-2)).met);
  // 2e-3 s surely misses: its small bar does not help it.
  EXPECT_EQ(choose_step({step(2e-3, 2e-2), step(1e-3, 1e-3, 3e-2)}, force(1e-2)).index, 1);
  const MeasuredError error{force(5e-3), force(7e-3)};
  EXPECT_DOUBLE_EQ(error.bound().force, 1.2e-2);
  EXPECT_EQ(error.least().force, 0);
  EXPECT_EQ(error_against(error, force(1e-2)), "force 5.0e-3 ± 7.0e-3 of 1.0e-2");
}

TEST(Advice, WithoutABarTheMeasuredErrorsChooseAndNothingIsMet) {
  std::vector<Advice::StepTrial> steps = {step(4e-3, 3, kInfinity), step(2e-3, 7e-3, kInfinity),
                                          step(1e-3, 5e-3, kInfinity), step(1e-2, 1e-4, kInfinity)};
  steps[3].accuracy = 0.1;
  steps[3].seconds = 1;
  // The equal steps miss 2e-3 by what was measured, and the accuracy does not.
  EXPECT_EQ(choose_step(steps, force(2e-3)).index, 3);
  EXPECT_EQ(choose_step(steps, force(1e-2)).index, 2);
  EXPECT_FALSE(choose_step(steps, force(1e-2)).met);
  EXPECT_FALSE(bars_known(steps[0].error, force(1e-2)));
  EXPECT_TRUE(bars_known(steps[0].error, {.energy = 1e-2}));
  EXPECT_EQ(error_against(steps[0].error, force(1e-2)), "force 3.0e0 ± unknown of 1.0e-2");
}

TEST(Advice, ARunThatEndsIsSaidWithoutTheListOfStages) {
  Advice advice;
  advice.trials = {trial("auto", 1e-2, 0, 1)};
  advice.choice = 0;
  advice.run.failure = "step 3: stages: pgs 9: stalled; admm 5: given up; ipm 7: iteration limit";
  conclude({}, advice);
  EXPECT_EQ(advice.message,
            "the run as advised ends: step 3: 3 stages, the last ipm 7: iteration limit");
}

TEST(Advice, AMissedGoalNamesTheLargestStepNearTheBest) {
  // The error stops falling: 1.1e-1 is within a quarter of 1e-1.
  const std::vector<Advice::StepTrial> steps = {step(4e-3, 5e-1), step(2e-3, 1.1e-1),
                                                step(1e-3, 1e-1)};
  const Advice::StepChoice choice = choose_step(steps, force(1e-2));
  EXPECT_EQ(choice.index, 1);
  EXPECT_FALSE(choice.met);
  EXPECT_EQ(choose_step({}, force(1e-2)).index, -1);
}

TEST(Advice, PaysForNoDigitsBelowWhatExactAnswersDifferBy) {
  // Answers 0.2 apart in force: an error of 0.2 is lost in that, one of 0.21 is not.
  const Accuracy spread{.force = 0.2, .energy = 1e-3};
  const Accuracy lost =
      without_lost_digits({.force = 0.2, .penetration = 0.5, .energy = 2e-3}, spread);
  EXPECT_EQ(lost.force, 0);
  EXPECT_EQ(lost.penetration, 0.5);  // an exact answer has none
  EXPECT_EQ(lost.energy, 2e-3);
  EXPECT_EQ(without_lost_digits(force(0.21), spread).force, 0.21);
  // A single answer: everything counts.
  EXPECT_EQ(without_lost_digits(force(1e-9), Accuracy{}).force, 1e-9);
}

TEST(Advice, TheSolverGetsWhatTheStepLeaves) {
  EXPECT_DOUBLE_EQ(solver_budget(force(1e-2), force(4e-3)).force, 6e-3);
  EXPECT_DOUBLE_EQ(solver_budget(force(1e-2), Accuracy{}).force, 1e-2);  // not measured
  // The step misses the goal: no digits below half of its own error.
  EXPECT_DOUBLE_EQ(solver_budget(force(1e-2), force(2e-1)).force, 1e-1);
  EXPECT_TRUE(std::isnan(solver_budget(force(1e-2), force(2e-1)).energy));
}

TEST(Advice, CheapestFirstOfThoseThatMeetTheBudget) {
  std::vector<Advice::SolverTrial> trials = {
      trial("slow", 1e-3, 1e-3, 5e-2), trial("loose", 1e-1, 5e-2, 1e-3),
      trial("fast", 1e-3, 2e-3, 1e-2), trial("fails", 1e-3, 1e-4, 1e-3)};
  trials[3].solved = 3;
  EXPECT_EQ(by_cost(trials, force(1e-2)), (std::vector<int>{2, 0}));
  EXPECT_TRUE(by_cost(trials, force(1e-5)).empty());
  EXPECT_EQ(nearest_trial(trials, force(1e-5)), 0);
}

TEST(Advice, TimesThatDifferByNoiseKeepTheirOrder) {
  const std::vector<Advice::SolverTrial> trials = {trial("first", 1e-3, 1e-3, 2e-6),
                                                   trial("second", 1e-3, 1e-3, 1e-6)};
  EXPECT_EQ(by_cost(trials, force(1e-2)), (std::vector<int>{0, 1}));
}

TEST(Advice, DigitsBelowTheSpreadOfExactRunsMeetTheBudget) {
  // Two exact runs 0.2 apart: 0.19 meets a budget of 0.01, 0.21 does not.
  const Accuracy spread = force(0.2);
  EXPECT_TRUE(meets(trial("a", 1e-3, 0.19, 1), force(1e-2), spread));
  EXPECT_FALSE(meets(trial("a", 1e-3, 0.21, 1), force(1e-2), spread));
  EXPECT_FALSE(meets(trial("a", 1e-3, 0.19, 1), force(1e-2)));
}

TEST(Advice, ExpectedErrorIsThatOfStepAndSolver) {
  Advice advice{.step_error = {force(2e-2), force(1e-3)}, .trials = {trial("a", 1e-3, 1e-2, 1)}};
  EXPECT_EQ(expected_error(advice).error.force, 2e-2);  // no choice
  advice.choice = 0;
  EXPECT_DOUBLE_EQ(expected_error(advice).error.force, 3e-2);
  EXPECT_DOUBLE_EQ(expected_error(advice).bound().force, 3.1e-2);
  EXPECT_TRUE(std::isnan(expected_error(advice).error.energy));
  // The overlap of a part of the run is a bound from below, that of all of it is the overlap.
  advice.step_error.error.penetration = 3e-2;
  advice.run = {.steps = 5, .steps_planned = 10, .overlap = 2e-2};
  EXPECT_EQ(expected_error(advice).error.penetration, 3e-2);
  advice.run.overlap = 4e-2;
  EXPECT_EQ(expected_error(advice).error.penetration, 4e-2);
  advice.run = {.steps = 10, .steps_planned = 10, .overlap = 2e-2};
  EXPECT_EQ(expected_error(advice).error.penetration, 2e-2);
}

TEST(Advice, SolversAreTriedOnTheDimensionsThatTheyTake) {
  const auto lemke = [](const SolverVariant& variant) { return variant.solver == "lemke"; };
  for (const int dim : {1, 2, 3}) {
    const std::vector<SolverVariant> tried = promising_solvers(10, dim);
    EXPECT_EQ(std::count_if(tried.begin(), tried.end(), lemke), dim < 3) << dim;
    EXPECT_GT(tried.size(), 4u);
  }
}

TEST(Advice, ParetoLeavesOutWhatIsBeatenInBoth) {
  std::vector<Advice::SolverTrial> trials = {
      trial("a", 1e-1, 1e-1, 1e-3), trial("b", 1e-3, 1e-3, 1e-2), trial("beaten", 1e-2, 1e-2, 2e-2),
      trial("fails", 1e-8, 1e-8, 1e-4)};
  trials[3].solved = 0;
  mark_pareto(trials, force(1e-2));
  EXPECT_TRUE(trials[0].pareto);
  EXPECT_TRUE(trials[1].pareto);
  EXPECT_FALSE(trials[2].pareto);
  EXPECT_FALSE(trials[3].pareto);
}

}  // namespace
}  // namespace bipot
