#pragma once

#include <filesystem>

#include "core/problem_files/problem_form.h"

namespace bipot {

/// Reads an FCLIB HDF5 file or a Siconos text file; the content decides, not the name. Throws
/// FileError with the reason if the file cannot be read or the problem is not sound.
ProblemFile read_problem(const std::filesystem::path& path);

}  // namespace bipot
