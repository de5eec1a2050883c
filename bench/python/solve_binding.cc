#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "bench/python/callable_solver.h"
#include "bench/python/python_problem.h"
#include "bench/python/python_watch.h"
#include "core/problem/delassus.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

namespace py = pybind11;

/// One judged iteration, as a row of numpy.
struct HistoryRow {
  std::int64_t iteration;
  double seconds, epsilon, eta, guarded, raw42, natural_map, step;
  std::int64_t take_off, stick, slip;
};

HistoryRow row_of(const IterationRecord& r) {
  return {r.iteration,       r.seconds,     r.error.epsilon,     r.error.eta,
          r.error.guarded(), r.error.raw42, r.error.natural_map, r.step,
          r.count.take_off,  r.count.stick, r.count.slip};
}

/// The fields of HistoryRow, described to numpy on demand: the module loads without numpy.
py::dtype history_type() {
  static const bool told = [] {
    PYBIND11_NUMPY_DTYPE(HistoryRow, iteration, seconds, epsilon, eta, guarded, raw42, natural_map,
                         step, take_off, stick, slip);
    return true;
  }();
  static_cast<void>(told);
  return py::dtype::of<HistoryRow>();
}

struct PythonResult {
  std::shared_ptr<const ContactProblem> problem;
  std::string solver;
  SolveResult solve;
  ContactCount count;
  std::vector<HistoryRow> history;
};
using HeldResult = std::shared_ptr<PythonResult>;

/// Hands the judged iterations to Python.
class IterationCallback {
 public:
  IterationCallback(const py::object& callback, PythonWatch& watch)
      : callback_(callback), watch_(watch) {}

  void operator()(const HistoryRow& row) const {
    const py::gil_scoped_acquire lock;
    try {
      const py::object answer = callback_(row);
      if (!answer.is_none() && py::bool_(answer)) watch_.stop();
    } catch (const py::error_already_set&) {
      watch_.keep(std::current_exception());
    }
  }

 private:
  const py::object& callback_;
  PythonWatch& watch_;
};

HeldResult solve_problem(const PythonProblem& given, const py::object& solver, double tol,
                         const py::object& s0, double time_limit, const std::string& stop,
                         int max_iterations, std::map<std::string, std::string> parameters,
                         const py::object& callback) {
  PythonWatch watch;
  const ChosenSolver chosen = choose_solver(solver, watch);
  auto result = std::make_shared<PythonResult>();
  result->problem = given.problem;
  result->solver = std::string(chosen.entry.name);
  SolverOptions options;
  options.tol = tol;
  options.time_limit = time_limit;
  options.stop = parse_stop_test(stop);
  options.max_iterations = max_iterations;
  options.parameters = std::move(parameters);
  if (!s0.is_none()) {
    options.s0 = to_vector(s0, "s0");
    if (options.s0.size() == 0 && given.problem->num_rows() > 0) {
      throw std::invalid_argument(
          fmt::format("start s0 has size 0, expected {}", given.problem->num_rows()));
    }
  }
  options.cancelled = [&watch] { return watch.stopped(); };
  const IterationCallback tell(callback, watch);
  const bool told = !callback.is_none();
  options.on_iteration = [&](const IterationRecord& record) {
    result->history.push_back(row_of(record));
    if (told) tell(result->history.back());
  };
  {
    const py::gil_scoped_release release;
    result->solve = solve(chosen.entry, *given.problem, options);
  }
  watch.rethrow();
  if (result->solve.status == SolveStatus::kInvalidInput) {
    throw std::invalid_argument(result->solve.message);
  }
  result->count = count_contacts(*given.problem, result->solve.s);
  return result;
}

py::object worst_contact(const ContactError& error) {
  const int worst = error.eta > error.epsilon ? error.worst_eta : error.worst_epsilon;
  if (worst < 0) return py::none();
  return py::int_(worst);
}

std::string representation(const PythonResult& r) {
  return fmt::format("<bipot.Result {}: {} ({}), error {:.2e}, {} iterations, {:.3g} s>", r.solver,
                     to_string(r.solve.status), r.solve.message, r.solve.error.guarded(),
                     r.solve.iterations, r.solve.setup_seconds + r.solve.solve_seconds);
}

void bind_iteration(py::module_& module) {
  py::class_<HistoryRow> iteration(
      module, "Iteration",
      "One judged iteration, as a callback of `solve` gets it; the fields of `Result.history`.");
  iteration.def_readonly("iteration", &HistoryRow::iteration, "Number of completed iterations.")
      .def_readonly("seconds", &HistoryRow::seconds, "Wall time since the solver began [s].")
      .def_readonly("epsilon", &HistoryRow::epsilon, "Guarded form of the paper's (42).")
      .def_readonly("eta", &HistoryRow::eta, "Natural map in energy.")
      .def_readonly("guarded", &HistoryRow::guarded, "max(epsilon, eta).")
      .def_readonly("raw42", &HistoryRow::raw42, "The paper's (42); nan where nothing slides.")
      .def_readonly("natural_map", &HistoryRow::natural_map, "Relative natural map.")
      .def_readonly("step", &HistoryRow::step, "The solver's own; nan where it has none.")
      .def_readonly("take_off", &HistoryRow::take_off, "Contacts without impulse.")
      .def_readonly("stick", &HistoryRow::stick, "Contacts inside the cone.")
      .def_readonly("slip", &HistoryRow::slip, "Contacts on its edge.");
}

void bind_result(py::module_& module) {
  /// A getter of a field of the solve, or of its error.
  const auto of_solve = [](auto SolveResult::*field) {
    return [field](const PythonResult& r) { return r.solve.*field; };
  };
  const auto of_error = [](auto ContactError::*field) {
    return [field](const PythonResult& r) { return r.solve.error.*field; };
  };
  py::class_<PythonResult, HeldResult>(
      module, "Result",
      R"(How a solve ended. Arrays are read-only views; errors are those of s, judged once more on the
original problem.)")
      .def_readonly("solver", &PythonResult::solver, "Its name.")
      .def_property_readonly(
          "s", [](const HeldResult& r) { return view_of(r->solve.s, py::cast(r)); },
          "(m,) impulse in the friction cone [N s].")
      .def_property_readonly(
          "u", [](const HeldResult& r) { return view_of(r->solve.u, py::cast(r)); },
          "(m,) W s + u_free [m/s].")
      .def_property_readonly(
          "v",
          [](const HeldResult& r) -> py::object {
            if (!r->problem->has_velocities()) return py::none();
            return copy_of(body_velocities(*r->problem, r->solve.s));
          },
          "(n,) velocities of the bodies [m/s, rad/s], computed at each call; None without bodies.")
      .def_property_readonly(
          "status", [](const PythonResult& r) { return std::string(to_string(r.solve.status)); },
          R"("converged", "nothing to do", "iteration limit", "time limit", "interrupted", "stalled",
"diverged" or "numerical failure".)")
      .def_property_readonly(
          "converged", [](const PythonResult& r) { return is_success(r.solve.status); },
          "The status is one of the first two.")
      .def_property_readonly("message", of_solve(&SolveResult::message),
                             "One sentence: why it ended.")
      .def_property_readonly("iterations", of_solve(&SolveResult::iterations),
                             "The solver's own count.")
      .def_property_readonly("setup_seconds", of_solve(&SolveResult::setup_seconds),
                             "Wall time of factorisations and copies that do not depend on s [s].")
      .def_property_readonly("solve_seconds", of_solve(&SolveResult::solve_seconds),
                             "Wall time of the iteration, criterion included [s].")
      .def_property_readonly("epsilon", of_error(&ContactError::epsilon),
                             "Guarded form of the paper's (42).")
      .def_property_readonly("eta", of_error(&ContactError::eta), "Natural map in energy.")
      .def_property_readonly(
          "guarded", [](const PythonResult& r) { return r.solve.error.guarded(); },
          "max(epsilon, eta): what tol is held against.")
      .def_property_readonly("raw42", of_error(&ContactError::raw42),
                             "The paper's error (42); nan where nothing slides.")
      .def_property_readonly("natural_map", of_error(&ContactError::natural_map),
                             "Relative natural map, scaled contact by contact: no units.")
      .def_property_readonly(
          "worst_contact", [](const PythonResult& r) { return worst_contact(r.solve.error); },
          "That which is worst in whichever of epsilon and eta is larger; None without one.")
      .def_property_readonly(
          "take_off", [](const PythonResult& r) { return r.count.take_off; },
          "Contacts without impulse.")
      .def_property_readonly(
          "stick", [](const PythonResult& r) { return r.count.stick; }, "Contacts inside the cone.")
      .def_property_readonly(
          "slip", [](const PythonResult& r) { return r.count.slip; }, "Contacts on its edge.")
      .def_property_readonly(
          "history",
          [](const HeldResult& r) {
            py::array history(history_type(), {static_cast<py::ssize_t>(r->history.size())},
                              {static_cast<py::ssize_t>(sizeof(HistoryRow))}, r->history.data(),
                              py::cast(r));
            history.attr("setflags")(py::arg("write") = false);
            return history;
          },
          R"(Structured array of the judged iterations: iteration, seconds, epsilon, eta, guarded,
raw42, natural_map, step, take_off, stick, slip. A read-only view.)")
      .def("__repr__", &representation);
}

std::string kind_of(ParameterSpec::Kind kind) {
  switch (kind) {
    case ParameterSpec::Kind::kNumber:
      return "number";
    case ParameterSpec::Kind::kInteger:
      return "integer";
    case ParameterSpec::Kind::kChoice:
      return "choice";
    case ParameterSpec::Kind::kText:
      return "text";
  }
  return "";
}

py::dict to_dict(const ParameterSpec& spec) {
  py::dict row;
  row["name"] = spec.name;
  row["kind"] = kind_of(spec.kind);
  row["default"] = spec.default_value;
  const bool numeric =
      spec.kind == ParameterSpec::Kind::kNumber || spec.kind == ParameterSpec::Kind::kInteger;
  row["minimum"] = numeric ? py::object(py::float_(spec.minimum)) : py::object(py::none());
  row["maximum"] = numeric ? py::object(py::float_(spec.maximum)) : py::object(py::none());
  row["choices"] = py::str(std::string(spec.choices)).attr("split")("|");
  if (spec.choices.empty()) row["choices"] = py::list();
  row["unit"] = spec.unit;
  row["help"] = spec.help;
  return row;
}

py::list list_solvers() {
  py::list rows;
  for (const SolverEntry& entry : solver_table()) {
    py::dict row;
    row["name"] = entry.name;
    row["summary"] = entry.summary;
    row["max_dim"] = entry.max_dim;
    row["max_contacts"] = entry.max_contacts;
    py::list parameters;
    for (const ParameterSpec& spec : entry.parameters) parameters.append(to_dict(spec));
    parameters.append(to_dict(kIslandsParameter));
    row["parameters"] = parameters;
    rows.append(row);
  }
  return rows;
}

/// Parameters of the solver; of all of them for an empty name. Throws std::invalid_argument.
std::vector<std::string> parameter_names(const std::string& solver) {
  std::set<std::string> names{std::string(kIslandsParameter.name)};
  for (const SolverEntry& entry : solver_table()) {
    if (!solver.empty() && entry.name != solver) continue;
    for (const ParameterSpec& spec : entry.parameters) names.emplace(spec.name);
  }
  if (!solver.empty()) require_solver(solver);
  return {names.begin(), names.end()};
}

}  // namespace

void bind_solve(py::module_& module) {
  bind_iteration(module);
  bind_result(module);
  module.def("solve", &solve_problem, py::arg("problem"), py::arg("solver"), py::arg("tol"),
             py::arg("s0"), py::arg("time_limit"), py::arg("stop"), py::arg("max_iterations"),
             py::arg("parameters"), py::arg("callback"));
  module.def("solvers", &list_solvers);
  module.def("parameter_names", &parameter_names, py::arg("solver"));
}

}  // namespace bipot
