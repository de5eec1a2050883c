#pragma once

namespace bipot {

/// Initialises MPI for this process, once, unless that has been done, and finalises it at the end
/// of the process. For libraries that expect MPI even in a single process (PETSc, MUMPS). Open MPI
/// is kept from handling the signals SIGSEGV, SIGBUS, SIGFPE and SIGABRT, unless the environment
/// names its signals. It is also kept from starting a daemon, which a single process does not need.
/// Throws std::runtime_error if MPI cannot be initialised or is finalised already.
void ensure_mpi();

}  // namespace bipot
