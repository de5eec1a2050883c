#pragma once

#include <functional>

#include "core/linear/system_factor.h"
#include "solvers/parallel/process_group.h"

namespace bipot {

/// ProcessGroup::run_on_root() on all processes of PETSC_COMM_WORLD, which must be alive: matrices
/// are cut into blocks of consecutive columns, one a process, and factored by MUMPS (PETSc's
/// MATSOLVERMUMPS; Amestoy, Duff, L'Excellent and Koster 2001), whose factor lies on all of them.
/// The analysis is kept while the pattern stays. Waiting processes sleep. Counted in `traffic`:
/// what goes to and from the root process; not what MUMPS sends.
void mumps_crew(const std::function<void(SystemFactor&)>& work, Traffic& traffic);

}  // namespace bipot
