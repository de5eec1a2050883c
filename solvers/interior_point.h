#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kInteriorPointParameters[] = {
    {.name = "start_scale",
     .kind = ParameterSpec::Kind::kNumber,
     .default_value = "1",
     .minimum = 1e-6,
     .maximum = 1e6,
     .help = "multiplies the default start's impulses"},
    {.name = "relaxation",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "on",
     .choices = "on|off",
     .help = "solve the associated (convex) law roughly first, then drop its dilatancy"},
    {.name = "arclength",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "on",
     .choices = "on|off",
     .help = "follow the central path through its folds where the first stage stops"},
    {.name = "polish",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "on",
     .choices = "on|off",
     .help = "proximal semismooth Newton from the best impulse, last stage"},
    {.name = "stage_iterations",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "150",
     .minimum = 1,
     .maximum = 100000,
     .help = "cap of the proximal interior point stage"},
    {.name = "arc_iterations",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "300",
     .minimum = 1,
     .maximum = 100000,
     .help = "cap of each arclength stage"},
    {.name = "rounds",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "6",
     .minimum = 1,
     .maximum = 1000,
     .help = "restarts from other start scales before giving up"},
    {.name = "linear_system",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "auto",
     .choices = "auto|body|contact",
     .help = "eliminate the contacts (needs a diagonal A), or the bodies"},
};

SolveResult solve_interior_point(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
