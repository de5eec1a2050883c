#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kGaussSeidelParameters[] = {
    {.name = "omega",
     .kind = ParameterSpec::Kind::kNumber,
     .default_value = "1",
     .minimum = 1e-3,
     .maximum = 1.999,
     .help = "relaxation of each local update"},
};

/// Projected block Gauss-Seidel, the NSGS of Jean (1999) and Moreau: contact after contact, the
/// local problem is updated by one projection with separate normal and tangential steps
/// 1/W_nn and 1/W_tt (the exact local solution wherever the diagonal block is diagonal: disks), and
/// velocities are refreshed at once.
SolveResult solve_gauss_seidel(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
