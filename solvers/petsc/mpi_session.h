#pragma once

namespace bipot {

/// Initialises MPI for this process, once, if nobody has, and finalises it at the end of the
/// process in that case. For libraries that are called here with one process but expect MPI to be
/// alive (PETSc, MUMPS). Open MPI is kept from taking over the signals SIGSEGV, SIGBUS, SIGFPE and
/// SIGABRT, unless the environment says which ones it may have, and from starting a daemon, which a
/// single process does not need. Throws std::runtime_error when MPI cannot be initialised or is
/// finalised already.
void ensure_mpi();

}  // namespace bipot
