#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/measure/problem_target.h"
#include "bench/tune/measure_rows.h"

namespace bipot {

/// plan.toml beside the target if that is one scene file, else in the working folder.
std::filesystem::path default_plan_file(const std::vector<std::string>& targets);

/// Measures the targets, computes a plan for `auto`, and writes it to `plan`. Unless quiet, progress
/// and regret are printed. Empty `options.file`: the rows go beside the plan. A stopped measurement
/// keeps its rows, and no plan is written, nor where no solver solved anything. Returns an ExitCode.
/// Throws std::invalid_argument if there are no rows, and FileError.
int tune_targets(const std::vector<std::string>& targets, TargetOptions scenes,
                 MeasureOptions options, int least_rows, const std::filesystem::path& plan,
                 bool quiet);

}  // namespace bipot
