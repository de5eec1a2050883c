#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace bipot {

struct ExtremesFlags {
  std::vector<std::string> solvers;  ///< empty: all
  std::string only;                  ///< a case, or how its name begins
  bool quick = false;
  double tol = 1e-8;
  std::optional<double> time_limit;  ///< CPU seconds of a cell
  std::string out;
  std::string dump_problem;  ///< FCLIB file for the one problem that --only or --first names
  int random_problems = 0, random_scenes = 0;
  std::uint64_t seed = 1;
  int first = 0;
  bool quiet = false;
};

/// Declares `bipot extremes`.
CLI::App* add_extremes_command(CLI::App& app, ExtremesFlags& flags);

/// The matrix of cases and solvers, or random sets. Ends with 1 where anything is wrong. Returns an
/// ExitCode.
int extremes_command(const ExtremesFlags& flags);

}  // namespace bipot
