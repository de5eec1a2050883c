#pragma once

#include <span>
#include <vector>

#include "bench/tune/greedy_schedule.h"

namespace bipot {

/// A leaf of the tree: its conditions and the greedy schedule of its instances.
struct TunedClass {
  PlanConditions conditions;
  std::vector<ScheduledStage> schedule;
  int solved = 0, measured = 0;
};

/// Cuts the instances into classes by a decision tree over properties, numbers of contacts and
/// tolerances (Breiman et al. 1984). A node is cut where that saves most of the expected time of
/// the schedules of its halves, in units of the best times; both have `least_rows` instances, and
/// at least a twentieth of the time is saved. The leaves are in an order in which the first whose
/// conditions hold is the right one.
std::vector<TunedClass> class_tree(std::span<const TunedInstance> instances, int least_rows);

/// Null: none of the classes.
const TunedClass* class_of(std::span<const TunedClass> classes, const ProblemTraits& problem);

}  // namespace bipot
