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

}  // namespace bipot
