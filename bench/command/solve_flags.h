#pragma once

#include <optional>
#include <string>

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

}  // namespace bipot
