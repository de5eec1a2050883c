#pragma once

#include <functional>
#include <memory>

#include "bench/command/command_line.h"
#include "bench/command/exit_code.h"

namespace bipot {

/// A command of the program: declared on its command line, run after that was parsed. `run` returns
/// an ExitCode, and throws std::invalid_argument or FileError before anything is done.
struct ProgramCommand {
  CommandDeclaration declaration;
  std::function<int()> run;
};

/// The command keeps its flags, which are filled when the line is parsed.
template <class Flags>
ProgramCommand make_command(CommandLine& line, CommandDeclaration (*declare)(CommandLine&, Flags&),
                            int (*run)(const Flags&)) {
  const auto flags = std::make_shared<Flags>();
  return {declare(line, *flags), [flags, run] { return run(*flags); }};
}

/// Tries solvers and time steps on a scene and prints a recommendation: 0 if the goal is met or
/// nothing touches.
ProgramCommand advise_command(CommandLine& line);
/// Fills the table of solver x problem x tolerance and writes it: 0 if it is complete.
ProgramCommand compare_command(CommandLine& line);
/// The matrix of cases and solvers, or random sets: 1 if anything is wrong.
ProgramCommand extremes_command(CommandLine& line);
/// Judges an impulse computed by any code for a problem file: 0 within the tolerance.
ProgramCommand judge_command(CommandLine& line);
/// Judges impulses of anybody for many problems: one page.
ProgramCommand leaderboard_command(CommandLine& line);
/// Names of solvers, scenes and problems.
ProgramCommand list_command(CommandLine& line);
/// A film of a run, by ffmpeg.
ProgramCommand movie_command(CommandLine& line);
/// Prints a scene to begin with.
ProgramCommand new_command(CommandLine& line);
/// Writes index.html of a run into its folder.
ProgramCommand page_command(CommandLine& line);
/// Reproduces the paper: index page, results.json, charts. Items of an earlier run in the same
/// folder stay unless they run now.
ProgramCommand paper_command(CommandLine& line);
/// Runs a scene: time steps, files, summary.
ProgramCommand run_command(CommandLine& line);
/// Solves one problem file; --out DIR puts summary.json, history.csv and solution.hdf5 there.
ProgramCommand solve_command(CommandLine& line);
/// Measures what exactness observables need, and draws it: 0 if all was measured.
ProgramCommand study_command(CommandLine& line);
/// Runs whole simulations and writes their analysis: 0 if all were run.
ProgramCommand trade_command(CommandLine& line);
/// Measures, computes a plan for `auto` and writes it.
ProgramCommand tune_command(CommandLine& line);
/// Measures observables with known values, at several tolerances each.
ProgramCommand validate_command(CommandLine& line);

}  // namespace bipot
