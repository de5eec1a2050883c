#pragma once

#include "solvers/solver.h"

namespace bipot {

/// Solves one contact, so that what a solver loads and initialises at its first call (PETSc, MPI)
/// is not part of a measurement.
void warm_up(const SolverEntry& entry);

}  // namespace bipot
