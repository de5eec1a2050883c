#include "solvers/petsc/mpi_session.h"

#include <mpi.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace bipot {
namespace {

/// Open MPI ends the program if it cannot write its files.
void find_writable_folder() {
  std::error_code unknown;
  const std::filesystem::path usual = std::filesystem::temp_directory_path(unknown);
  for (const std::filesystem::path& folder : {usual, std::filesystem::path("/tmp")}) {
    if (folder.empty() || ::access(folder.c_str(), W_OK | X_OK) != 0) continue;
    if (folder != usual) setenv("OMPI_MCA_orte_tmpdir_base", folder.c_str(), 0);
    return;
  }
  throw std::runtime_error("MPI needs a folder that it can write to: set TMPDIR");
}

class MpiSession {
 public:
  MpiSession() {
    int alive = 0;
    MPI_Initialized(&alive);
    if (alive) return;  // the host program uses MPI itself
    find_writable_folder();
    setenv("OMPI_MCA_opal_signal", "", 0);
    // A process that waits leaves its core to the others, which may be more than the cores.
    setenv("OMPI_MCA_mpi_yield_when_idle", "1", 0);
    // A single process needs no daemon: without this Open MPI starts one (orted) and leaves it.
    setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    // Nor a folder: two such programs at once would make and remove the same one.
    if (std::getenv("OMPI_COMM_WORLD_SIZE") == nullptr) {
      setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
    }
    // Other threads compute and write while one calls MPI.
    int provided = 0;
    owned_ = MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided) == MPI_SUCCESS;
  }
  ~MpiSession() {
    int finalised = 0;
    MPI_Finalized(&finalised);
    if (owned_ && !finalised) MPI_Finalize();
  }
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;

 private:
  bool owned_ = false;
};

}  // namespace

void ensure_mpi() {
  static const MpiSession session;
  int alive = 0, finalised = 0;
  MPI_Initialized(&alive);
  MPI_Finalized(&finalised);
  if (!alive || finalised) {
    throw std::runtime_error("MPI cannot be initialised, or is already finalised");
  }
}

}  // namespace bipot
