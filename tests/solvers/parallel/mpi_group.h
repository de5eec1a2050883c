#pragma once

#include "solvers/parallel/process_group.h"

namespace bipot {

/// All processes of this mpirun.
ProcessGroup& mpi_group();

}  // namespace bipot
