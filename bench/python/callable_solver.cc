#include "bench/python/callable_solver.h"

#include <fmt/format.h>

#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

namespace py = pybind11;

/// Text of an exception of Python code, as in "ValueError: no".
std::string words_of(const py::error_already_set& e) {
  const std::string type = py::str(e.type().attr("__name__"));
  const std::string text = py::str(e.value());
  return text.empty() ? type : type + ": " + text;
}

/// Data of callback(s); Python may keep the callback after the solve.
struct Callback {
  SolveRun* run = nullptr;
  int iterations = -1;  ///< completed ones: the start counts as none
  bool stop = false;

  bool operator()(const py::object& s) {
    if (run == nullptr) throw std::runtime_error("the solve that this callback is of is over");
    const Vector x = to_vector(s, "s");
    const Eigen::Index rows = run->problem().num_rows();
    if (rows != x.size()) {
      throw std::invalid_argument(fmt::format("s has size {}, expected {}", x.size(), rows));
    }
    const py::gil_scoped_release release;
    if (!stop) stop = run->stop(++iterations, x);
    return stop;
  }
};

}  // namespace

CallableSolver::CallableSolver(std::string name, py::object callable, PythonWatch& watch)
    : name_(std::move(name)), callable_(std::move(callable)), watch_(watch) {}

SolverEntry CallableSolver::entry() const {
  SolverEntry entry;
  entry.name = name_;
  entry.summary = "a Python callable";
  entry.run = [this](SolveRun& solve) { run(solve); };
  return entry;
}

void CallableSolver::run(SolveRun& run) const {
  const ContactProblem& problem = run.problem();
  const py::gil_scoped_acquire lock;
  const auto callback = std::make_shared<Callback>();
  callback->run = &run;
  const auto detach = [](Callback* c) { c->run = nullptr; };
  const std::unique_ptr<Callback, decltype(detach)> detached(callback.get(), detach);
  Vector s;
  try {
    const py::object answer = callable_(
        std::make_shared<PythonProblem>(problem), run.options().tol,
        py::cpp_function([callback](const py::object& x) { return (*callback)(x); }, py::arg("s")));
    if (answer.is_none()) {
      throw std::runtime_error(
          fmt::format("returned None, expected an array of {} numbers", problem.num_rows()));
    }
    s = to_vector(answer, "s");
  } catch (py::error_already_set& e) {
    if (e.matches(PyExc_Exception)) throw std::runtime_error(words_of(e));
    watch_.keep(std::current_exception());  // Ctrl-C, exit()
    throw std::runtime_error("interrupted");
  }
  SolveResult result;
  if (callback->stop) {
    result = run.finish();
  } else {
    result.status = SolveStatus::kConverged;
    result.message = "returned an answer";
    result.iterations = std::max(0, callback->iterations);
    result.solve_seconds = run.seconds();
  }
  result.s = std::move(s);
  run.take(std::move(result));
}

ChosenSolver choose_solver(const py::object& solver, PythonWatch& watch) {
  ChosenSolver chosen;
  if (py::isinstance<py::str>(solver)) {
    chosen.entry = require_solver(solver.cast<std::string>());
    return chosen;
  }
  if (PyCallable_Check(solver.ptr()) == 0) {
    throw py::type_error("solver: expected a name or a callable f(problem, tol, callback) -> s");
  }
  chosen.callable = std::make_unique<CallableSolver>(name_of_callable(solver), solver, watch);
  chosen.entry = chosen.callable->entry();
  return chosen;
}

std::string name_of_callable(const py::object& callable) {
  const py::object named =
      py::hasattr(callable, "__name__") ? callable : py::object(py::type::of(callable));
  return named.attr("__name__").cast<std::string>();
}

}  // namespace bipot
