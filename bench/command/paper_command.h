#pragma once

#include <string>
#include <vector>

#include "bench/command/command_line.h"

namespace bipot {

struct PaperFlags {
  std::vector<std::string> only;
  bool quick = false, quiet = false;
  std::string out = "out/paper";
  std::string json;
};

/// Declares `bipot paper`.
CommandDeclaration add_paper_command(CommandLine& line, PaperFlags& flags);

/// Reproduces the paper's figures and tables: index page, results.json, pictures and their data.
/// Items of an earlier run in the same folder stay unless they run now. Returns an ExitCode. Throws
/// std::invalid_argument for an unknown item, FileError.
int paper_command(const PaperFlags& flags);

}  // namespace bipot
