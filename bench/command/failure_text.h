#pragma once

#include <span>
#include <string>

#include "bench/scenes/scene_run.h"

namespace bipot {

/// What to say of a step whose problem was not solved: its worst contact, whether a solution exists at all
/// (solvers/certificate), the three likeliest causes and what to try, most telling first. Lines, each
/// with its end.
std::string failure_text(const Scene& scene, const State& state,
                         std::span<const ContactOutcome> contacts, const ContactProblem& problem,
                         const ContactError& error, int step);
/// The same for a step that was not taken; `state` is that before it.
std::string failure_text(const Scene& scene, const State& state, const SceneRun& run);

/// Watches whether contacts create energy, which Newton's impact law may do where coefficients of restitution
/// differ (data/method.md §3).
class EnergyGrowth {
 public:
  explicit EnergyGrowth(const State& start) : loss_(start.friction_loss + start.shock_loss) {}
  void add(const Scene& scene, const SceneStep& step);
  /// One line; empty when nothing grew beyond what tolerance and rounding leave.
  std::string warning(const Scene& scene) const;

 private:
  double loss_;  // of the steps before, since step 0                                 [J]
  double largest_ = 0, energy_ = 0;
  int steps_ = 0, step_ = -1;
};

}  // namespace bipot
