#pragma once

#include <string>

#include "bench/command/command_line.h"

namespace bipot {

struct NewFlags {
  std::string name;  ///< of a template; empty: they are listed
};

/// Declares `bipot new`.
CommandDeclaration add_new_command(CommandLine& line, NewFlags& flags);

/// Prints a scene to begin with. Returns an ExitCode.
int new_command(const NewFlags& flags);

}  // namespace bipot
