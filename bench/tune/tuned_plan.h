#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/tune/class_tree.h"
#include "bench/tune/measure_rows.h"

namespace bipot {

struct TunedPlan {
  /// Times of one way to solve the instances, over those of the best variant on each.
  struct Regret {
    std::string name;
    double median = kNaN, ninth_tenth = kNaN, worst = kNaN;  ///< unsolved: infinite
    int solved = 0;
    int of = 0;  ///< instances that some variant solves, and this one could run
  };
  std::vector<TunedClass> classes;
  std::vector<Regret> regret;  ///< of the plan, cross-validated and not, of `auto`, of variants
  std::vector<TunedVariant> variants;
};

/// The plan for these rows. Rows of variants that are not in the list do not count. The
/// cross-validation leaves out one scene after the other, in at most ten parts.
TunedPlan tune_plan(std::span<const MeasuredRow> rows, std::span<const TunedVariant> variants,
                    int least_rows);

/// As a plan file. After its own stages each class goes on with those of the shipped plan.
std::string plan_text(const TunedPlan& plan, const std::string& comment);
std::string regret_text(const TunedPlan& plan);

}  // namespace bipot
