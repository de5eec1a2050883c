#pragma once

#include <span>
#include <string>
#include <vector>

#include "solvers/solver.h"

namespace bipot {

/// The one table of solvers of this build, in the order of presentation.
std::span<const SolverEntry> solver_table();

/// Null when no solver has that name.
const SolverEntry* find_solver(std::string_view name);

std::vector<std::string> solver_names();

/// For a name that find_solver() does not know: the nearest one, or the build option that this build
/// lacks.
std::string unknown_solver_message(std::string_view name);

}  // namespace bipot
