#pragma once

#include "solvers/solver.h"

namespace bipot {

/// Solves one contact, so that libraries that a solver loads at its first call (PETSc, MPI) are not
/// part of a measurement.
void warm_up(const SolverEntry& entry);

}  // namespace bipot
