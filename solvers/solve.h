#pragma once

#include <string>
#include <string_view>

#include "core/base/stopwatch.h"
#include "solvers/contact_space.h"
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

// The parts of it, for whoever makes the space himself:

/// Why solve() refuses, in a sentence; empty where it does not. `problem`: the contacts that are
/// here.
std::string refusal(const SolverEntry& entry, const ContactProblem& problem,
                    const SolverOptions& options);
/// All but the refusals. `watch`: runs since the set-up began. Collective.
SolveResult solve_in(ContactSpace& space, const SolverEntry& entry, const SolverOptions& options,
                     const Stopwatch& watch);

}  // namespace bipot
