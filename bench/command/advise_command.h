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

/// Tries solvers and time steps on the scene and prints what to take. Returns an ExitCode: 0 when
/// the goal is met or nothing touches, 1 when it is not met.
int advise_command(const AdviseFlags& flags);

}  // namespace bipot
