#pragma once

#include <string>

#include "bench/command/command_line.h"

namespace bipot {

struct JudgeFlags {
  std::string problem;   ///< FCLIB HDF5 or Siconos text
  std::string impulses;  ///< empty: /solution of the problem file
  double tol = 1e-8;
  std::string order = "contact";  ///< or "component"
  std::string components, negated;
  double factor = 1;
  int worst = 5;                   ///< contacts that are named
  bool accept_indefinite = false;  ///< take a W that is no Delassus operator
  bool quiet = false;
  std::string json;
};

/// Declares `bipot judge`.
CommandDeclaration add_judge_command(CommandLine& line, JudgeFlags& flags);

/// Judges an impulse computed by any code for a problem file. Returns an ExitCode: 0 within the
/// tolerance, 1 not.
int judge_command(const JudgeFlags& flags);

}  // namespace bipot
