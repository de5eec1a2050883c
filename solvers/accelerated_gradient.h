#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kAcceleratedGradientParameters[] = {
    {.name = "map",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "cone",
     .choices = "cone|split",
     .help = "projection on the cone with de Saxce's term, or normal part first, then the disk"},
    {.name = "step",
     .kind = ParameterSpec::Kind::kNumber,
     .default_value = "1",
     .minimum = 1e-3,
     .maximum = 2,
     .help = "step in multiples of 1/lambda_max"},
};

SolveResult solve_accelerated_gradient(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
