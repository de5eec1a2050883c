#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/command/command_line.h"
#include "bench/tradeoff/advice.h"

namespace bipot {

struct AdviseFlags {
  std::string scene;
  Accuracy goal;                     ///< empty: default_goal of the scene
  std::vector<std::string> solvers;  ///< empty: the promising ones
  double time_limit = 60;
  std::optional<double> window;
  int samples = 6;
  bool keep_step = false, quiet = false, force_overwrite = false, all = false;
  std::string out, json, write;
};

/// Declares `bipot advise`.
CommandDeclaration add_advise_command(CommandLine& line, AdviseFlags& flags);

/// Tries solvers and time steps on the scene and prints a recommendation. Returns an ExitCode: 0 if
/// the goal is met or there are no contacts, 1 if it is not met.
int advise_command(const AdviseFlags& flags);

}  // namespace bipot
