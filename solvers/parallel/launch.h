#pragma once

#include <memory>

#include "solvers/parallel/process_group.h"

namespace bipot {

/// How many processes a launcher (mpirun, mpiexec, srun) says that it started, from the environment
/// alone: MPI is not touched. 1 where there is no launcher.
int launched_processes();
/// The rank that the launcher gave this process; 0 where there is no launcher.
int launched_rank();

/// All launched processes, which starts MPI; a lone process, without MPI, where there is one. Throws
/// std::invalid_argument for several in a build without PETSc.
std::unique_ptr<ProcessGroup> launched_group();

/// Ends all launched processes at once with this exit code: for a process that failed while others
/// wait for it. Does not return.
[[noreturn]] void end_all_processes(int exit_code);

}  // namespace bipot
