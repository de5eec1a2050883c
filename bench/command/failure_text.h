#pragma once

#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "solvers/simulation/scene_run.h"

namespace bipot {

/// Text on a step whose problem was not solved: its worst contact, whether a solution exists at all
/// (solvers/analysis), the three likeliest causes and their remedies, most informative first.
/// Smaller steps are left out if they were tried. `said`: the reason that was given; a verdict in it
/// is not repeated, and no cause but rounding is sought where it says so. Lines, each with its end.
template <int D>
std::string failure_text(const Scene<D>& scene, const State<D>& state,
                         std::span<const std::type_identity_t<ContactOutcome<D>>> contacts,
                         const ContactProblem& problem, const ContactError& error, int step,
                         bool smaller_steps_tried, std::string_view said = {});
/// The same for a failed step; `state` is that before it.
template <int D>
std::string failure_text(const Scene<D>& scene, const State<D>& state, const SceneRun<D>& run,
                         bool smaller_steps_tried);

/// What to try where bodies would go through each other in the step after `state`. `springs`: of
/// the model dem, else null. Lines.
template <int D>
std::string passage_advice(const Scene<D>& scene, const State<D>& state,
                           const SpringDashpotSetup* springs, bool smaller_steps_tried);

/// On deep overlaps and on pairs that went through each other: a line each; empty if none.
template <int D>
std::string motion_warning(const Scene<D>& scene, const SceneTotals<D>& totals);

/// Detects whether contacts create energy, which Newton's impact law may do if coefficients of
/// restitution differ (data/manual/explanation/method.md §3).
template <int D>
class EnergyGrowth {
 public:
  EnergyGrowth(const Scene<D>& scene, const State<D>& start);
  void add(const Scene<D>& scene, const StepReport<D>& report);
  /// One line; empty if no energy grew beyond tolerance and rounding.
  std::string warning(const Scene<D>& scene) const;

 private:
  double loss_;   // of the steps before, since step 0                                [J]
  double scale_;  // energies below its rounding are nothing: a fall by a radius, and all so far
  double largest_ = 0, energy_ = 0;
  int steps_ = 0, step_ = -1;
};

}  // namespace bipot
