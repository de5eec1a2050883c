#pragma once

#include <functional>

#include "core/linear/system_factor.h"
#include "solvers/parallel/process_group.h"

namespace bipot {

/// ProcessGroup::run_on_root() on all processes of PETSC_COMM_WORLD, which must be alive. Matrices
/// are cut into blocks of consecutive columns, one for each process, and factored by MUMPS (PETSc's
/// MATSOLVERMUMPS; Amestoy, Duff, L'Excellent and Koster 2001), whose factor is distributed. The
/// analysis is reused while the pattern stays. Waiting processes sleep. `traffic` counts messages
/// from and to the root process, not those of MUMPS.
void run_with_parallel_factor(const std::function<void(SystemFactor&)>& work,
                              ProcessGroup::Traffic& traffic);

}  // namespace bipot
