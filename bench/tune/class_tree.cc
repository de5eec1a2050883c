#include "bench/tune/class_tree.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace bipot {
namespace {

using Members = std::vector<const TunedInstance*>;

constexpr double kLeastSaving = 0.05;
constexpr int kDeepest = 6;
constexpr double kContacts[] = {20, 50, 100, 200, 400, 1000, 2500, 4000, 8000, 20000};
// Each with the other word for all others, if there is one.
constexpr unsigned kFirst[] = {kWarm, kDisks, kVectors, kUnequal, kBodies, kInPlane, kClosePacked};
constexpr unsigned kOther[] = {kCold, kNoDisks, kNoVectors, 0, kWAlone, kInSpace, 0};

struct Plan {
  std::vector<ScheduledStage> schedule;
  double cost = 0;
  int solved = 0;
};

Plan plan_of(const Members& members) {
  Plan plan{greedy_schedule(members)};
  for (const TunedInstance* instance : members) {
    bool solved = false;
    plan.cost += seconds_of(plan.schedule, *instance, &solved) / instance->best;
    plan.solved += solved;
  }
  return plan;
}

/// A condition, and that of all others.
struct Cut {
  PlanConditions inside, outside;
};

std::vector<Cut> cuts_of(const Members& members) {
  std::vector<Cut> cuts;
  for (std::size_t k = 0; k < std::size(kFirst); ++k) {
    cuts.push_back({{.marks = kFirst[k]}, {.marks = kOther[k]}});
  }
  for (const double contacts : kContacts)
    cuts.push_back({{.up_to = contacts}, {.above = contacts}});
  std::set<double> tols;
  for (const TunedInstance* member : members) tols.insert(member->traits.tol);
  for (auto tol = tols.begin(); tol != tols.end() && std::next(tol) != tols.end(); ++tol) {
    const double between = std::sqrt(*tol * *std::next(tol));
    cuts.push_back({{.tol_below = between}, {.tol_from = between}});
  }
  return cuts;
}

PlanConditions both(PlanConditions a, const PlanConditions& b) {
  a.above = std::max(a.above, b.above);
  a.up_to = std::min(a.up_to, b.up_to);
  a.tol_from = std::max(a.tol_from, b.tol_from);
  a.tol_below = std::min(a.tol_below, b.tol_below);
  a.marks |= b.marks;
  return a;
}

void grow(const Members& members, const PlanConditions& conditions, Plan plan, int least_rows,
          int depth, std::vector<TunedClass>& leaves) {
  Cut best_cut;
  Members best_inside, best_outside;
  Plan plan_inside, plan_outside;
  double least = (1 - kLeastSaving) * plan.cost;
  for (const Cut& cut : depth < kDeepest ? cuts_of(members) : std::vector<Cut>()) {
    Members inside, outside;
    for (const TunedInstance* member : members) {
      (cut.inside.hold(member->traits) ? inside : outside).push_back(member);
    }
    const auto rows = static_cast<std::size_t>(std::max(1, least_rows));
    if (inside.size() < rows || outside.size() < rows) continue;
    Plan first = plan_of(inside), second = plan_of(outside);
    if (first.cost + second.cost >= least) continue;
    least = first.cost + second.cost;
    best_cut = cut;
    best_inside = std::move(inside);
    best_outside = std::move(outside);
    plan_inside = std::move(first);
    plan_outside = std::move(second);
  }
  if (best_inside.empty()) {
    leaves.push_back(
        {conditions, std::move(plan.schedule), plan.solved, static_cast<int>(members.size())});
    return;
  }
  grow(best_inside, both(conditions, best_cut.inside), std::move(plan_inside), least_rows,
       depth + 1, leaves);
  grow(best_outside, both(conditions, best_cut.outside), std::move(plan_outside), least_rows,
       depth + 1, leaves);
}

/// What all have in common, with a margin of a factor of two in size and of three in tolerance.
PlanConditions common(const Members& members) {
  PlanConditions made{.marks = ~0U};
  double most = 0, loosest = 0;
  double fewest = kInfinity, tightest = kInfinity;
  for (const TunedInstance* member : members) {
    made.marks &= member->traits.marks;
    most = std::max<double>(most, member->traits.contacts);
    fewest = std::min<double>(fewest, member->traits.contacts);
    loosest = std::max(loosest, member->traits.tol);
    tightest = std::min(tightest, member->traits.tol);
  }
  made.above = std::floor(fewest / 2);
  made.up_to = 2 * most;
  made.tol_from = tightest / 3;
  made.tol_below = 3 * loosest;
  return made;
}

}  // namespace

std::vector<TunedClass> class_tree(std::span<const TunedInstance> instances, int least_rows) {
  Members members;
  for (const TunedInstance& instance : instances) {
    if (instance.best > 0) members.push_back(&instance);
  }
  std::vector<TunedClass> leaves;
  if (members.empty()) return leaves;
  grow(members, common(members), plan_of(members), least_rows, 0, leaves);
  return leaves;
}

const TunedClass* class_of(std::span<const TunedClass> classes, const ProblemTraits& problem) {
  for (const TunedClass& of : classes) {
    if (of.conditions.hold(problem)) return &of;
  }
  return nullptr;
}

}  // namespace bipot
