#pragma once

#include "solvers/auto/islands.h"
#include "solvers/auto/plan.h"
#include "solvers/solve_run.h"

namespace bipot {

/// Runs the stages that the plan has for the problem (auto_plan.h, stage_race.h). The parameter
/// `plan` names a file; empty: the shipped plan. Budgets grow from stage to stage, so that a wrong
/// first guess costs a multiple of the best solver's time, not all of it.
///
/// Parts that do not couple are solved one by one (islands.h) unless options.islands is false: the
/// stages marked as such are tried on the whole first, where most of what is easy is solved. In
/// parallel there are no islands. A problem of W alone is solved by its disks, if it has them
/// (recovered_disks.h).
void solve_auto(SolveRun& run);

/// The same for parts, by the stages of this plan, which must live.
IslandSolver plan_solver(const AutoPlan& plan);

inline constexpr ParameterSpec kAutoParameters[] = {
    ParameterSpec::choice(kIslandsParameter.name, "on", kIslandsParameter.choices,
                          kIslandsParameter.help),
    ParameterSpec::text(
        "plan", "",
        "file of the plan of stages, as `bipot tune` writes it; empty: the shipped plan"),
    ParameterSpec::choice(
        "forces", "any", "any|spread",
        "any: of many force networks also that of load_path; spread: not, as in all runs"),
};

}  // namespace bipot
