#pragma once

#include <string>

#include "core/problem/contact_problem.h"
#include "solvers/solver.h"

namespace bipot {

/// Solves within `seconds` of CPU time (CpuLimit); beyond it the status is kTimeLimit. `s0` may be
/// empty.
SolveResult solve_within(const std::string& solver, const ContactProblem& problem, double tol,
                         double seconds, const Vector& s0 = {});

}  // namespace bipot
