#pragma once

#include <filesystem>

#include "core/problem_files/problem_form.h"

namespace bipot {

/// Reads an FCLIB HDF5 file or a Siconos text file; the content decides, not the name. Throws
/// FileError with the reason if the file cannot be read or the problem is not sound. `untrusted`:
/// Hdf5File::check_structure() comes first.
ProblemFile read_problem(const std::filesystem::path& path, bool untrusted = false);

}  // namespace bipot
