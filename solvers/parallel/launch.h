#pragma once

#include <memory>

#include "solvers/parallel/process_group.h"

namespace bipot {

/// Number of processes that a launcher (mpirun, mpiexec, srun) started, from the environment alone,
/// without MPI. 1 without a launcher.
int launched_processes();
/// The rank that the launcher gave this process; 0 without a launcher.
int launched_rank();

/// All launched processes, which starts MPI; for a single process a group without MPI. Throws
/// std::invalid_argument for several in a build without PETSc.
std::unique_ptr<ProcessGroup> launched_group();

/// Ends all launched processes at once with this exit code: for a process that failed while others
/// wait for it. Does not return.
[[noreturn]] void end_all_processes(int exit_code);

}  // namespace bipot
