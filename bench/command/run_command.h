#pragma once

#include "bench/command/command_line.h"
#include "bench/command/command_options.h"

namespace bipot {

struct RunFlags {
  CommonFlags common;
  SolverFlags solver;
  std::string scene;
  std::optional<int> steps;
  std::optional<double> step_size, duration, accuracy;
  std::string restart;        ///< folder or run.h5 of an earlier run
  bool overwrite = false;     ///< deletes a run in the folder of the results
  std::string dump_problems;  ///< "", "all" or "failed"
  /// "continue", "stop", "smaller-step"; empty: continue, but not where there is no solution
  std::string on_failure;
  std::string on_tunnel = "stop";  ///< or "warn", "smaller-step"
  std::optional<std::string> model;
  bool no_page = false;
  bool watch = false;  ///< serves the page while the run goes on
  std::optional<int> port;
  bool reproducible = false;  ///< exact sums, the same bits for any number of processes
  /// Parameters of the spring-dashpot model; unset entries leave the scene's choice.
  std::optional<double> stiffness, overlap, tangential_ratio, substep;
};

/// Declares `bipot run`.
CommandDeclaration add_run_command(CommandLine& line, RunFlags& flags);

/// Runs a scene: time steps, files, summary. Returns an ExitCode.
int run_command(const RunFlags& flags);

}  // namespace bipot
