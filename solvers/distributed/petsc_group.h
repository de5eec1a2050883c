#pragma once

#include <memory>
#include <string>

#include "solvers/distributed/process_group.h"

namespace bipot {

/// All processes that the launcher started. Starts MPI and PETSc where nobody has. Exchanges are
/// PETSc's star forests (PetscSF): a copy is one message to each process that holds copies of this
/// one's originals. Throws PetscFailure or std::runtime_error.
std::unique_ptr<ProcessGroup> petsc_group();

/// Ends all processes of the run at once, this one's exit code for all: for a process that failed
/// while others wait for it. Does not return.
[[noreturn]] void end_all_processes(int exit_code);

}  // namespace bipot
