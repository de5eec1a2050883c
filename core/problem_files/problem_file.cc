#include "core/problem_files/problem_file.h"

#include "core/files/hdf5_file.h"
#include "core/files/input_file.h"
#include "core/problem_files/fclib_file.h"
#include "core/problem_files/siconos_text_file.h"

namespace bipot {

ProblemFile read_problem(const std::filesystem::path& path, bool accept_indefinite) {
  require_regular_file(path);
  if (path.extension() == ".toml") {
    throw FileError(path, "", "a scene, not a contact problem: 'bipot run' takes it");
  }
  Hdf5File::check_structure(path);
  ProblemFile file = Hdf5File::is_hdf5(path) ? read_fclib(path) : read_siconos_text(path);
  file.caution = delassus_defect(file.problem);
  if (!file.caution.empty() && !accept_indefinite) throw FileError(path, "W", file.caution);
  return file;
}

}  // namespace bipot
