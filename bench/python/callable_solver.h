#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "bench/python/python_watch.h"
#include "solvers/solve_run.h"

namespace bipot {

/// A Python callable f(problem, tol, callback) -> s as a solver. callback(s) judges an iterate as
/// those of the built-in solvers, at the cadence of SolveRun. It returns true for a stop:
/// the tolerance is met, or time is over, or the solve stagnates. The returned impulse is projected
/// and judged once more by solve(). An answer without a stop is a claim of convergence. Exceptions
/// of f are a failure of the solver with Python's text, except KeyboardInterrupt and the like,
/// which end everything. The solver's time includes a copy of the problem.
class CallableSolver {
 public:
  /// `watch` must outlive all runs. Call with Python's lock held.
  CallableSolver(std::string name, pybind11::object callable, PythonWatch& watch);

  /// The row for solve() and compare(); it refers to this object.
  SolverEntry entry() const;

 private:
  void run(SolveRun& run) const;

  std::string name_;
  pybind11::object callable_;
  PythonWatch& watch_;
};

/// A solver of a user: a name of the table, or a callable.
struct ChosenSolver {
  std::unique_ptr<CallableSolver> callable;  ///< null: the table's
  SolverEntry entry;
};
/// Throws std::invalid_argument for an unknown name, TypeError for any other type.
ChosenSolver choose_solver(const pybind11::object& solver, PythonWatch& watch);

/// __name__ of a callable, else the name of its class.
std::string name_of_callable(const pybind11::object& callable);

}  // namespace bipot
