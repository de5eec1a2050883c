#pragma once

#include <string>
#include <vector>

#include "bench/command/command_line.h"

namespace bipot {

struct TuneFlags {
  std::vector<std::string> targets, solvers;
  std::vector<double> tols;
  double time_limit = 2;  ///< CPU seconds of one solve
  int scene_problems = 6, least_rows = 20;
  std::string out, rows;
  bool quiet = false;
};

/// Declares `bipot tune`.
CommandDeclaration add_tune_command(CommandLine& line, TuneFlags& flags);

/// Measures, computes a plan for `auto` and writes it. Returns an ExitCode.
int tune_command(const TuneFlags& flags);

}  // namespace bipot
