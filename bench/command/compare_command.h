#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/command/command_line.h"

namespace bipot {

struct CompareFlags {
  std::vector<std::string> targets;
  std::vector<std::string> solvers = {"all"};
  std::vector<double> tols;                    ///< empty: 1e-2, 1e-4, 1e-6, 1e-8; quick 1e-2, 1e-6
  std::optional<double> time_limit;            ///< of one solve, 2 s; quick 1 s
  std::optional<double> reference_time_limit;  ///< of one attempt, 5 s; quick 3 s
  int threads = 1;
  int repeat = 1;
  double min_time = 0.02;  ///< of the repeats of a short solve together, CPU [s]
  bool try_all = false;
  bool warm = false;                  ///< warm rows beside the cold ones
  std::optional<int> scene_problems;  ///< 3; quick 1
  std::optional<int> scene_steps;     ///< all; quick 100
  /// Scenes run as a whole, beside the problems; "set": the set of `bipot trade`.
  std::vector<std::string> whole_runs;
  bool quick = false, quiet = false;
  std::string out, json;
};

/// Declares `bipot compare`.
CommandDeclaration add_compare_command(CommandLine& line, CompareFlags& flags);

/// Fills the table of solver x problem x tolerance and writes it. Returns an ExitCode: 0 if the
/// table is complete, for any contents.
int compare_command(const CompareFlags& flags);

}  // namespace bipot
