#pragma once

#include <string>

namespace bipot {

/// The program's version: that of the CMake project, "major.minor.patch".
std::string program_version();

}  // namespace bipot
