#include "solvers/parallel/launch.h"

#include <cstdlib>
#include <stdexcept>
#include <utility>

#include "core/base/number_text.h"
#ifdef BIPOT_WITH_PETSC
#include "solvers/parallel/petsc_group.h"
#endif

namespace bipot {
namespace {

/// A number in the environment, or -1.
int from_environment(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? -1 : whole_number<int>(text).value_or(-1);
}

/// Open MPI; MPICH and its relatives; Slurm, if it provides MPI itself.
struct Launcher {
  const char *size, *rank;
};
constexpr Launcher kLaunchers[] = {{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"},
                                   {"PMI_SIZE", "PMI_RANK"},
                                   {"SLURM_NTASKS", "PMIX_RANK"}};

/// Number of processes and own rank.
std::pair<int, int> launched() {
  for (const Launcher& launcher : kLaunchers) {
    const int size = from_environment(launcher.size), rank = from_environment(launcher.rank);
    if (size > 0 && rank >= 0) return {size, rank};
  }
  return {1, 0};
}

}  // namespace

int launched_processes() { return launched().first; }
int launched_rank() { return launched().second; }

std::unique_ptr<ProcessGroup> launched_group() {
  if (launched_processes() == 1) return lone_process();
#ifdef BIPOT_WITH_PETSC
  return petsc_group();
#else
  throw std::invalid_argument(
      "this build has no PETSc (BIPOT_WITH_PETSC=OFF): it runs on one process");
#endif
}

void end_all_processes(int exit_code) {
#ifdef BIPOT_WITH_PETSC
  abort_mpi(exit_code);
#endif
  std::exit(exit_code);
}

}  // namespace bipot
