#include "core/problem_files/problem_file.h"

#include "core/files/hdf5_file.h"
#include "core/files/input_file.h"
#include "core/problem_files/fclib_file.h"
#include "core/problem_files/siconos_text_file.h"

namespace bipot {

ProblemFile read_problem(const std::filesystem::path& path) {
  require_regular_file(path);
  Hdf5File::check_structure(path);
  return Hdf5File::is_hdf5(path) ? read_fclib(path) : read_siconos_text(path);
}

}  // namespace bipot
