#pragma once

namespace bipot {

/// Exit codes of the `bipot` command, stable.
enum ExitCode : int {
  kExitConverged = 0,         ///< every solve met its tolerance
  kExitNotConverged = 1,      ///< results are written, but some solve missed its tolerance
  kExitBadInput = 2,          ///< command line, scene or problem refused; nothing was run
  kExitNumericalFailure = 3,  ///< a solver failed, or no solution exists; results are written
  kExitIo = 4,                ///< a file could not be read or written
  kExitInterrupted = 5        ///< Ctrl-C; results up to that step are written
};

}  // namespace bipot
