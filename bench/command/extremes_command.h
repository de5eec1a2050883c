#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/command/command_line.h"

namespace bipot {

struct ExtremesFlags {
  std::vector<std::string> solvers;  ///< empty: all
  std::string only;                  ///< a case, or how its name begins
  bool quick = false;
  double tol = 1e-8;
  std::optional<double> time_limit;  ///< CPU seconds of a cell
  std::string out;
  std::string json;          ///< "-": standard output
  std::string dump_problem;  ///< FCLIB file for the one problem that --only or --first names
  int random_problems = 0, random_scenes = 0;
  std::uint64_t seed = 1;
  int first = 0;
  bool quiet = false;
};

/// Declares `bipot extremes`.
CommandDeclaration add_extremes_command(CommandLine& line, ExtremesFlags& flags);

/// The matrix of cases and solvers, or random sets. Returns an ExitCode: 1 if anything is wrong.
int extremes_command(const ExtremesFlags& flags);

}  // namespace bipot
