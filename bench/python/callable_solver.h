#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "bench/python/python_watch.h"
#include "solvers/solve_run.h"

namespace bipot {

/// A Python callable f(problem, tol, callback) -> s as a solver. callback(s) judges an iterate as
/// those of the built-in solvers are judged, at the cadence of SolveRun, and says whether to
/// stop: the tolerance is met, or time or patience are over. Whatever is returned is projected and
/// judged once more by solve(); an answer without a callback that said stop is a claim of
/// convergence. What f raises is a failure of the solver with Python's words, but for
/// KeyboardInterrupt and the like, which end everything. The time of handing the problem over (a
/// copy) is the solver's.
class CallableSolver {
 public:
  /// `watch` must outlive all runs. Call with Python's lock held.
  CallableSolver(std::string name, pybind11::object callable, PythonWatch& watch);

  /// The row for solve() and compare(); it keeps looking at this object.
  SolverEntry entry() const;

 private:
  void run(SolveRun& run) const;

  std::string name_;
  pybind11::object callable_;
  PythonWatch& watch_;
};

/// What a user gave as one solver: a name of the table, or a callable.
struct ChosenSolver {
  std::unique_ptr<CallableSolver> callable;  ///< null: the table's
  SolverEntry entry;
};
/// Throws std::invalid_argument for an unknown name, TypeError for what is neither.
ChosenSolver choose_solver(const pybind11::object& solver, PythonWatch& watch);

/// __name__ of a callable, else the name of its class.
std::string name_of_callable(const pybind11::object& callable);

}  // namespace bipot
