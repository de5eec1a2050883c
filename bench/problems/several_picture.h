#pragma once

#include <filesystem>
#include <string>

#include "core/problem_files/problem_geometry.h"
#include "solvers/analysis/several_answers.h"

namespace bipot {

/// Several answers of one step over its disks: normal forces of the first answer as segments; each
/// disk coloured by the largest difference between two answers of the resultant contact force on it,
/// over the mean resultant; a ring around each contact whose status differs. Throws FileError, and
/// std::invalid_argument without answers.
void draw_several_picture(const std::filesystem::path& path, const ContactProblem& problem,
                          const ProblemGeometry& geometry, const SeveralAnswers& found,
                          const std::string& title);

}  // namespace bipot
