#include "bench/tune/greedy_schedule.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

std::vector<const TunedInstance*> all(const std::vector<TunedInstance>& instances) {
  std::vector<const TunedInstance*> pointers;
  for (const TunedInstance& instance : instances) pointers.push_back(&instance);
  return pointers;
}

/// Variant 0 solves the first instance in 1 s and 10 iterations, the second not in 10 s and 100.
/// Variant 1 solves both in 3 s. In units of the best times 1 and 3 s:
///   10 iterations of 0:  one solved for 1/1 + 1/3   rate 0.75
///   all of 1:            two solved for 3/1 + 3/3   rate 0.5
/// so 0 comes first, and costs 1 + (1 + 3)/3 = 7/3; 1 alone costs 3 + 1 = 4.
const std::vector<TunedInstance> kTwo{
    {.outcomes = {{10, 1, true}, {6, 3, true}}, .limit = 20, .best = 1},
    {.outcomes = {{100, 10, false}, {6, 3, true}}, .limit = 20, .best = 3}};

TEST(GreedySchedule, ABudgetForTheQuickOneThenTheSureOne) {
  const std::vector<ScheduledStage> schedule = greedy_schedule(all(kTwo));
  ASSERT_EQ(schedule.size(), 2u);
  EXPECT_EQ(schedule[0].variant, 0u);
  EXPECT_EQ(schedule[0].budget, 10);
  EXPECT_EQ(schedule[1].variant, 1u);
  EXPECT_EQ(schedule[1].budget, 6);
  bool solved = false;
  EXPECT_DOUBLE_EQ(seconds_of(schedule, kTwo[0], &solved), 1);
  EXPECT_TRUE(solved);
  EXPECT_DOUBLE_EQ(seconds_of(schedule, kTwo[1], &solved), 4);
  EXPECT_TRUE(solved);
}

TEST(GreedySchedule, WhatTheLimitCutsOffCostsTheLimit) {
  TunedInstance second = kTwo[1];
  second.limit = 3.5;
  bool solved = true;
  EXPECT_DOUBLE_EQ(seconds_of(greedy_schedule(all(kTwo)), second, &solved), 3.5);
  EXPECT_FALSE(solved);
}

/// Two budgets of one variant, one after the other, are one stage. Instances of 1, 1 and 4 s, 10, 10
/// and 40 iterations: the smaller budget solves two for 1 + 1 + 1/4, the larger one for 3/4 more.
TEST(GreedySchedule, OneVariantTwiceIsOneStage) {
  const std::vector<TunedInstance> three{{.outcomes = {{10, 1, true}}, .limit = 9, .best = 1},
                                         {.outcomes = {{10, 1, true}}, .limit = 9, .best = 1},
                                         {.outcomes = {{40, 4, true}}, .limit = 9, .best = 0.5}};
  const std::vector<ScheduledStage> schedule = greedy_schedule(all(three));
  ASSERT_EQ(schedule.size(), 1u);
  EXPECT_EQ(schedule[0].budget, 40);
  EXPECT_DOUBLE_EQ(seconds_of(schedule, three[2]), 4);
}

/// A variant that is taken up again costs what is left of its budget: 1 s of 4, 2 s of the other,
/// then 3 s.
TEST(GreedySchedule, AVariantIsTakenUpWithALargerBudget) {
  const TunedInstance instance{.outcomes = {{40, 4, true}, {50, 5, true}}, .limit = 9, .best = 4};
  const std::vector<ScheduledStage> schedule{{0, 10}, {1, 20}, {0, 40}};
  EXPECT_DOUBLE_EQ(seconds_of(schedule, instance), 6);
}

TEST(GreedySchedule, WhatNobodySolvesIsNotScheduled) {
  const std::vector<TunedInstance> none{{.outcomes = {{10, 1, false}}, .limit = 9, .best = 0}};
  EXPECT_TRUE(greedy_schedule(all(none)).empty());
  EXPECT_DOUBLE_EQ(seconds_of({}, none[0]), 9);
}

}  // namespace
}  // namespace bipot
