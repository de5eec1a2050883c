#pragma once

#include <filesystem>
#include <string>

#include "core/problem_files/problem_geometry.h"
#include "solvers/analysis/several_answers.h"

namespace bipot {

/// Draws several answers of one step over its disks. Segments show normal forces of the first
/// answer. The colour of a disk is the largest difference between two answers of the resultant
/// contact force on it, over the mean resultant. A ring marks each contact whose status differs.
/// A single answer has neither.
/// Throws FileError, and std::invalid_argument without answers.
void draw_several_picture(const std::filesystem::path& path, const ContactProblem& problem,
                          const ProblemGeometry& geometry, const SeveralAnswers& found,
                          const std::string& title);

}  // namespace bipot
