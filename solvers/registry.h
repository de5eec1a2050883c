#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/solver.h"

namespace bipot {

/// The one table of solvers of this build, in the order of presentation (methods/solver_table.cc).
std::span<const SolverEntry> solver_table();

/// Solvers of another law, for contrast, or of ordered packings alone. They have names and run like
/// the others, but no loop over the table and no comparison of all solvers takes them.
std::span<const SolverEntry> special_solvers();

/// A row of either table; null when no solver has that name.
const SolverEntry* find_solver(std::string_view name);

/// The row of that name; throws std::invalid_argument(unknown_solver_message(name)).
const SolverEntry& require_solver(std::string_view name);

/// Throws std::invalid_argument for a name that is unknown or stands there twice.
void require_solvers(std::span<const std::string> names);

/// The solver's own parameters, then the one that all solvers take.
std::vector<ParameterSpec> all_parameters(const SolverEntry& entry);

/// Of solver_table(); of all rows.
std::vector<std::string> solver_names();
std::vector<std::string> all_solver_names();

/// The same solver on each uncoupled part of a problem, one by one (auto/islands.h).
SolverEntry on_islands(const SolverEntry& entry);

/// For a name unknown to find_solver(): the nearest one, or the build option that this build lacks.
std::string unknown_solver_message(std::string_view name);

}  // namespace bipot
