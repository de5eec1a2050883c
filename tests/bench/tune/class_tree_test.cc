#include "bench/tune/class_tree.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

/// Warm ones are quick with variant 0, cold ones with variant 1; the other takes ten times as long.
std::vector<TunedInstance> two_kinds() {
  std::vector<TunedInstance> made;
  for (int k = 0; k < 40; ++k) {
    const bool warm = k % 2 == 0;
    const double first = warm ? 1 : 10, second = warm ? 10 : 1;
    made.push_back({.traits = {.contacts = 100 + k,
                               .dim = 2,
                               .tol = 1e-3,
                               .marks = kInPlane | kBodies | (warm ? kWarm : kCold)},
                    .outcomes = {{first, first, true}, {second, second, true}},
                    .limit = 50,
                    .best = 1});
  }
  return made;
}

TEST(ClassTree, CutsWhereOtherVariantsAreQuick) {
  const std::vector<TunedInstance> instances = two_kinds();
  const std::vector<TunedClass> classes = class_tree(instances, 10);
  ASSERT_EQ(classes.size(), 2u);
  for (const TunedInstance& instance : instances) {
    const TunedClass* of = class_of(classes, instance.traits);
    ASSERT_NE(of, nullptr);
    ASSERT_EQ(of->schedule.size(), 1u);
    EXPECT_EQ(of->schedule[0].variant, (instance.traits.marks & kWarm) ? 0u : 1u);
    EXPECT_EQ(of->solved, 20);
    EXPECT_EQ(of->measured, 20);
  }
}

TEST(ClassTree, LeavesHaveTheLeastNumberOfRows) {
  EXPECT_EQ(class_tree(two_kinds(), 21).size(), 1u);
  EXPECT_EQ(class_tree(two_kinds(), 20).size(), 2u);
}

/// Nothing is said of problems that are unlike all that were measured: in space, or twice as large.
TEST(ClassTree, OtherProblemsHaveNoClass) {
  const std::vector<TunedInstance> instances = two_kinds();
  const std::vector<TunedClass> classes = class_tree(instances, 10);
  ProblemTraits other = instances[0].traits;
  other.contacts = 2 * 139;
  EXPECT_NE(class_of(classes, other), nullptr);
  other.contacts += 1;
  EXPECT_EQ(class_of(classes, other), nullptr);
  other = instances[0].traits;
  other.marks = kInSpace | kBodies | kWarm;
  EXPECT_EQ(class_of(classes, other), nullptr);
  other = instances[0].traits;
  other.tol = 1e-5;
  EXPECT_EQ(class_of(classes, other), nullptr);
}

}  // namespace
}  // namespace bipot
