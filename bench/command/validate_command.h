#pragma once

#include <string>
#include <vector>

#include "bench/command/command_line.h"

namespace bipot {

struct ValidateFlags {
  std::vector<std::string> only;
  bool quick = false, quiet = false;
  std::string solver = "apgd";
  int max_iterations = 20000;
  std::string out, json;
};

/// Declares `bipot validate`.
CommandDeclaration add_validate_command(CommandLine& line, ValidateFlags& flags);

/// Measures observables with known values, at several tolerances each. Returns an ExitCode. Throws
/// std::invalid_argument for an unknown row or solver, FileError.
int validate_command(const ValidateFlags& flags);

}  // namespace bipot
