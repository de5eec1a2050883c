#pragma once

#include <memory>

#include "solvers/parallel/process_group.h"

namespace bipot {

/// All processes that the launcher started. Starts MPI and PETSc if necessary. Exchanges are
/// PETSc's star forests (PetscSF): a copy is one message to each process that holds copies of this
/// one's originals. Throws PetscFailure or std::runtime_error.
std::unique_ptr<ProcessGroup> petsc_group();

/// Calls MPI_Abort if MPI is alive.
void abort_mpi(int exit_code);

}  // namespace bipot
