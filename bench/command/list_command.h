#pragma once

#include <string>

#include "bench/command/command_line.h"

namespace bipot {

struct ListFlags {
  std::string what;  ///< "solvers" or "scenes"
  std::string name;  ///< of one solver; empty: all
  std::string json;
};

/// Declares `bipot list`.
CommandDeclaration add_list_command(CommandLine& line, ListFlags& flags);

int list_command(const ListFlags& flags);

}  // namespace bipot
