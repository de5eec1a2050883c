#pragma once

#include <string>
#include <vector>

#include "solvers/solver.h"

namespace bipot {

/// One stage of the chain that `auto` runs, and why it stands there.
struct AutoStage {
  std::string solver;
  int max_iterations = 0;  ///< of this stage, by the solver's own count
  std::map<std::string, std::string> parameters;
  std::string reason;
};

/// The chain for this problem, from its size, contact dimension, hyperstaticity (more active rows
/// than degrees of freedom), start and tolerance. The caps count iterations, not seconds, so that
/// the result does not depend on the machine. The rule is the table in auto_solver.cc, taken from
/// measurements (README, "Which solver").
std::vector<AutoStage> plan_auto(const ContactProblem& problem, const SolverOptions& options);

/// The plan in words, one line a stage.
std::string explain_auto(const ContactProblem& problem, const SolverOptions& options);

/// Runs the stages of plan_auto in turn, each from the best impulse so far, until one meets the
/// stop test; the message says which stages ran, how they ended and which one succeeded. With
/// the guarded test, a success whose natural map is above the tolerance is carried on to a ten
/// times smaller one, so that users who judge by either measure are served. No stage is
/// hidden: when all fail, the status is that of the last one and the impulse the best one.
/// `iterations` is the sum over stages, whose iterations differ much in cost.
SolveResult solve_auto(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
