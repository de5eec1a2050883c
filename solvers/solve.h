#pragma once

#include <string_view>

#include "solvers/solver.h"

namespace bipot {

/// Runs the named solver on the problem. It validates the problem and the options. It returns at
/// once if there are no contacts or the start already meets the stop test (0 iterations). It runs
/// the solver, projects the returned impulse on K_mu, and judges it on the original data. A claim
/// of convergence that does not hold there is withdrawn (kNumericalFailure, with both figures in
/// the message). Never throws, neither for bad input nor a failing solver nor for lack of memory,
/// that of OpenBLAS's buffer included: the status and the message report it. The options are passed
/// by value, so that a start that is moved in is not stored twice. Several threads may solve at
/// once (not by Siconos' solvers, which call dense kernels without a DenseTurn).
///
/// Precondition: W, if given, is a Delassus operator. For one of unknown origin ask
/// delassus_defect() (core/problem/contact_problem.h) first: with another W an impulse can meet the
/// criterion and still not solve the problem.
SolveResult solve(std::string_view solver, const ContactProblem& problem,
                  SolverOptions options = {});

/// The same for an entry that need not be in the registry.
SolveResult solve(const SolverEntry& entry, const ContactProblem& problem,
                  SolverOptions options = {});

}  // namespace bipot
