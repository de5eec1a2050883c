#pragma once

#include <optional>
#include <string>

#include "bench/command/command_line.h"
#include "bench/command/command_options.h"

namespace bipot {

struct SolveFlags {
  CommonFlags common;
  SolverFlags solver;
  std::string problem;             ///< FCLIB HDF5 or Siconos text
  std::string solution;            ///< FCLIB file whose /solution is written
  bool warm = false;               ///< start from the file's first guess
  bool explain = false;            ///< print the plan of `auto`
  bool accept_indefinite = false;  ///< take a W that is no Delassus operator
  bool certify = false;            ///< say whether a solution exists, with proof
  std::string history;             ///< CSV of the judged iterations
  std::optional<int> several;      ///< starts of a search for several answers
  bool reproducible = false;       ///< exact sums, the same bits for any number of processes
};

/// Declares `bipot solve`.
CommandDeclaration add_solve_command(CommandLine& line, SolveFlags& flags);

/// Solves one problem file; --out DIR puts summary.json, history.csv and solution.hdf5 there.
/// Returns an ExitCode.
int solve_command(const SolveFlags& flags);

}  // namespace bipot
