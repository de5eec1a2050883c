#pragma once

#include <string>

#include "bench/command/command_line.h"

namespace bipot {

struct PageFlags {
  std::string run;  ///< folder or run.h5
};

/// Declares `bipot page`.
CommandDeclaration add_page_command(CommandLine& line, PageFlags& flags);

/// Writes index.html of a run into its folder. Returns an ExitCode.
int page_command(const PageFlags& flags);

}  // namespace bipot
