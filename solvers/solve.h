#pragma once

#include <string_view>

#include "solvers/solver.h"

namespace bipot {

/// Runs the named solver on the problem: validates the problem and the options, returns at once
/// where there is nothing to do or the start already meets the stop test (0 iterations), runs,
/// projects the returned impulse on K_mu, and judges it on the original data. A claim of
/// convergence that does not hold there is withdrawn (kNumericalFailure, with both figures in the
/// message). Never throws for bad input, a failing solver or where memory
/// runs out, OpenBLAS's buffer included: the status and the message say it. The options by value: a
/// start that is moved in is not held twice.
SolveResult solve(std::string_view solver, const ContactProblem& problem,
                  SolverOptions options = {});

/// The same for an entry that need not stand in the registry.
SolveResult solve(const SolverEntry& entry, const ContactProblem& problem,
                  SolverOptions options = {});

}  // namespace bipot
