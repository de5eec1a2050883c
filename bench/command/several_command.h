#pragma once

#include "bench/command/solve_flags.h"
#include "core/problem_files/problem_file.h"

namespace bipot {

/// `bipot solve PROBLEM --several N`: searches for several exact answers. --out DIR gets
/// index.html, summary.json, answers.csv, answers.hdf5 (the problem with the answers as guesses)
/// and, if the file has its geometry, answers.svg and answers.png. Returns an ExitCode.
int several_command(const SolveFlags& flags, const ProblemFile& file);

}  // namespace bipot
