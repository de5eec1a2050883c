#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/command/command_line.h"

namespace bipot {

struct AdviseFlags {
  std::string scene;
  std::optional<double> force, penetration, energy;  ///< goals, see Accuracy
  std::vector<std::string> solvers;                  ///< empty: the promising ones
  double time_limit = 60;
  std::optional<double> window;
  int samples = 6, fresh = 3;
  bool keep_step = false, quiet = false, force_overwrite = false;
  std::string json, write;
};

/// Declares `bipot advise`.
CommandDeclaration add_advise_command(CommandLine& line, AdviseFlags& flags);

/// Tries solvers and time steps on the scene and prints a recommendation. Returns an ExitCode: 0 if
/// the goal is met or there are no contacts, 1 if it is not met.
int advise_command(const AdviseFlags& flags);

}  // namespace bipot
