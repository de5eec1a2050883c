#pragma once

#include <filesystem>
#include <string>

#include "bench/experiments/validation_run.h"

namespace bipot {

/// A line for each row and tolerance.
std::string to_csv(const ValidationPage& page);
/// A line for each row: what is expected, what came out, and the verdict.
std::string verdicts_csv(const ValidationPage& page);
/// The same for reading, with the reason of what does not hold.
std::string to_text(const ValidationPage& page);
/// Relative error against tolerance, a line for each row of the group. What is 0 (inside its
/// bounds), or below 1e-12, stands on the axis.
Chart error_chart(const ValidationPage& page, const std::string& group);
/// Groups in the order of the page.
std::vector<std::string> groups_of(const ValidationPage& page);
/// Name of a group's error chart in files.
std::string error_chart_name(const ValidationPage& page, const std::string& group);

/// index.html, validate.csv, verdicts.csv, and each chart as .svg, .csv and .gp. Throws FileError.
void write_validation(const std::filesystem::path& folder, const ValidationPage& page);

}  // namespace bipot
