#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "bench/python/callable_solver.h"
#include "bench/python/python_watch.h"
#include "core/base/file_error.h"
#include "core/base/version.h"
#include "core/problem/delassus.h"
#include "core/problem/equality_rows.h"
#include "solvers/auto/plan.h"
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
  const ContactCount count = r.count();
  return {r.iteration,       r.seconds,     r.error.epsilon,     r.error.eta,
          r.error.guarded(), r.error.raw42, r.error.natural_map, r.step,
          count.take_off,    count.stick,   count.slip};
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
  double tol = 0;
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
  py::object callback_;
  PythonWatch& watch_;
};

/// The plan that the parameters name, if they do. Throws std::invalid_argument.
std::shared_ptr<const AutoPlan> usable_plan(const std::map<std::string, std::string>& parameters) {
  try {
    return named_plan(parameters);
  } catch (const FileError& e) {
    throw std::invalid_argument(e.what());
  }
}

/// What all solves of a call share.
struct SolveRequest {
  py::object solver;  ///< a name or a callable
  double tol, time_limit;
  std::string stop;
  int max_iterations;
  std::map<std::string, std::string> parameters;
  py::object callback;  ///< or None
  /// Read before the clock starts.
  std::shared_ptr<const AutoPlan> plan = usable_plan(parameters);
};

/// One solve; all but run() with Python's lock held.
class PythonSolve {
 public:
  /// `stop`: ends the solve; must outlive it.
  PythonSolve(const PythonProblem& given, const SolveRequest& request, const py::object& s0,
              const std::atomic<bool>& stop)
      : caution_(given.caution),
        chosen_(choose_solver(request.solver, watch_)),
        tell_(request.callback, watch_),
        result_(std::make_shared<PythonResult>()) {
    result_->problem = given.problem;
    result_->solver = std::string(chosen_.entry.name);
    result_->tol = options_.tol = request.tol;
    options_.time_limit = request.time_limit;
    options_.stop = parse_stop_test(request.stop);
    options_.max_iterations = request.max_iterations;
    options_.parameters = request.parameters;
    options_.plan = request.plan;
    if (!s0.is_none()) {
      options_.s0 = to_vector(s0, "s0");
      if (options_.s0.size() == 0 && given.problem->num_rows() > 0) {
        throw std::invalid_argument(
            fmt::format("start s0 has size 0, expected {}", given.problem->num_rows()));
      }
    }
    options_.cancelled = [this, &stop] { return stop || watch_.stopped(); };
    const bool told = !request.callback.is_none();
    options_.on_iteration = [this, told](const IterationRecord& record) {
      result_->history.push_back(row_of(record));
      if (told) tell_(result_->history.back());
    };
  }
  PythonSolve(const PythonSolve&) = delete;  // the options refer to it
  PythonSolve& operator=(const PythonSolve&) = delete;

  /// Without Python's lock.
  void run() {
    result_->solve = solve(chosen_.entry, *result_->problem, std::move(options_));
    if (result_->solve.status == SolveStatus::kInvalidInput) return;
    if (!caution_.empty()) result_->solve.message += "; " + caution_;
    result_->count = count_contacts(*result_->problem, result_->solve.s);
  }
  /// True if Python code raised, or Ctrl-C was pressed.
  bool raised() const { return watch_.raised(); }
  /// Throws what Python code raised, and std::invalid_argument for bad input.
  HeldResult finish() const {
    watch_.rethrow();
    if (result_->solve.status == SolveStatus::kInvalidInput) {
      throw std::invalid_argument(result_->solve.message);
    }
    return result_;
  }

 private:
  PythonWatch watch_;
  std::string caution_;  // of the problem
  ChosenSolver chosen_;
  IterationCallback tell_;
  HeldResult result_;
  SolverOptions options_;
};

HeldResult solve_problem(const PythonProblem& given, const py::object& solver, double tol,
                         const py::object& s0, double time_limit, const std::string& stop,
                         int max_iterations, std::map<std::string, std::string> parameters,
                         const py::object& callback) {
  const std::atomic<bool> never = false;
  PythonSolve one(given,
                  {.solver = solver,
                   .tol = tol,
                   .time_limit = time_limit,
                   .stop = stop,
                   .max_iterations = max_iterations,
                   .parameters = std::move(parameters),
                   .callback = callback},
                  s0, never);
  {
    const py::gil_scoped_release release;
    one.run();
  }
  return one.finish();
}

/// Runs the solves on so many threads, each as if it were alone. The calling thread looks after
/// Ctrl-C. Without Python's lock.
void run_all(const std::vector<std::unique_ptr<PythonSolve>>& solves, int threads,
             std::atomic<bool>& stop, PythonWatch& watch) {
  std::mutex mutex;
  std::condition_variable changed;
  int active = std::min(threads, static_cast<int>(solves.size()));
  std::atomic<std::size_t> next = 0;
  std::vector<std::thread> workers;
  const auto work = [&] {
    for (std::size_t k = next++; k < solves.size() && !stop; k = next++) {
      solves[k]->run();
      if (solves[k]->raised()) stop = true;
    }
    const std::lock_guard<std::mutex> lock(mutex);
    --active;
    changed.notify_one();
  };
  for (int k = active; k > 0; --k) workers.emplace_back(work);
  std::unique_lock<std::mutex> lock(mutex);
  while (!changed.wait_for(lock, std::chrono::milliseconds(50), [&] { return active == 0; })) {
    lock.unlock();  // Python code in the workers may hold Python's lock
    if (watch.stopped()) stop = true;
    lock.lock();
  }
  lock.unlock();
  for (std::thread& worker : workers) worker.join();
}

std::vector<HeldResult> solve_all(const std::vector<std::shared_ptr<PythonProblem>>& problems,
                                  const py::object& solver, double tol,
                                  const std::vector<py::object>& s0, double time_limit,
                                  const std::string& stop, int max_iterations,
                                  std::map<std::string, std::string> parameters, int threads) {
  const SolveRequest request{.solver = solver,
                             .tol = tol,
                             .time_limit = time_limit,
                             .stop = stop,
                             .max_iterations = max_iterations,
                             .parameters = std::move(parameters),
                             .callback = py::none()};
  std::atomic<bool> over = false;
  PythonWatch watch;
  std::vector<std::unique_ptr<PythonSolve>> solves;
  for (std::size_t k = 0; k < problems.size(); ++k) {
    const py::object start = s0.empty() ? py::object(py::none()) : s0[k];
    solves.push_back(std::make_unique<PythonSolve>(*problems[k], request, start, over));
  }
  {
    const py::gil_scoped_release release;
    run_all(solves, threads, over, watch);
  }
  watch.rethrow();
  for (const auto& one : solves) {
    if (one->raised()) one->finish();
  }
  std::vector<HeldResult> results;
  for (std::size_t k = 0; k < solves.size(); ++k) {
    try {
      results.push_back(solves[k]->finish());
    } catch (const std::invalid_argument& e) {
      throw std::invalid_argument(fmt::format("problem {}: {}", k, e.what()));
    }
  }
  return results;
}

/// The bytes of plain data, for pickle, and the data again.
template <class Plain>
py::bytes bytes_of(const Plain* data, std::size_t count) {
  static_assert(std::is_trivially_copyable_v<Plain>);
  return {reinterpret_cast<const char*>(data), count * sizeof(Plain)};
}
template <class Plain>
std::vector<Plain> plain_of(const py::handle& bytes) {
  const auto text = bytes.cast<std::string>();
  std::vector<Plain> data(text.size() / sizeof(Plain));
  if (text.size() != data.size() * sizeof(Plain)) {
    throw std::invalid_argument("not the parts of a Result");
  }
  std::copy_n(text.data(), text.size(), reinterpret_cast<char*>(data.data()));
  return data;
}

/// All of a result, for pickle; for the same version alone.
py::tuple parts_of_result(const PythonResult& r) {
  const SolveResult& x = r.solve;
  return py::make_tuple(program_version(), std::make_shared<PythonProblem>(r.problem), r.solver,
                        r.tol, static_cast<int>(x.status), x.message, copy_of(x.s), copy_of(x.u),
                        bytes_of(&x.error, 1), x.iterations, x.setup_seconds, x.solve_seconds,
                        bytes_of(&r.count, 1), bytes_of(r.history.data(), r.history.size()));
}

HeldResult result_of_parts(const py::tuple& parts) {
  if (parts.size() != 14 || parts[0].cast<std::string>() != program_version()) {
    throw std::invalid_argument(
        fmt::format("a Result that another version pickled; this is bipot {}", program_version()));
  }
  auto r = std::make_shared<PythonResult>();
  r->problem = parts[1].cast<std::shared_ptr<PythonProblem>>()->problem;
  r->solver = parts[2].cast<std::string>();
  r->tol = parts[3].cast<double>();
  SolveResult& x = r->solve;
  x.status = static_cast<SolveStatus>(parts[4].cast<int>());
  x.message = parts[5].cast<std::string>();
  x.s = to_vector(parts[6], "s");
  x.u = to_vector(parts[7], "u");
  x.error = plain_of<ContactError>(parts[8]).at(0);
  x.iterations = parts[9].cast<int>();
  x.setup_seconds = parts[10].cast<double>();
  x.solve_seconds = parts[11].cast<double>();
  r->count = plain_of<ContactCount>(parts[12]).at(0);
  r->history = plain_of<HistoryRow>(parts[13]);
  return r;
}

/// s without the scale of restitution.
Vector impulse_of(const PythonResult& r) {
  const Vector& scale = r.problem->row_scale;
  return scale.size() == 0 ? r.solve.s : Vector(r.solve.s.cwiseQuotient(scale));
}

py::object worst_contact(const ContactError& error) {
  return contact_or_none(error.eta > error.epsilon ? error.worst_eta : error.worst_epsilon);
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
  refuse_new(iteration);
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
  py::class_<PythonResult, HeldResult> result(
      module, "Result",
      R"(How a solve ended. Arrays are read-only views; errors are those of s, judged once more on the
original problem. True in a condition if it converged.)");
  refuse_new(result);
  result.def_readonly("solver", &PythonResult::solver, "Its name.")
      .def_readonly("tol", &PythonResult::tol, "What was asked for.")
      .def_property_readonly(
          "s", [](const HeldResult& r) { return view_of(r->solve.s, py::cast(r)); },
          "(m,) impulse in the friction cone [N s].")
      .def_property_readonly(
          "u", [](const HeldResult& r) { return view_of(r->solve.u, py::cast(r)); },
          "(m,) W s + u_free [m/s].")
      .def_property_readonly(
          "impulse", [](const PythonResult& r) { return copy_of(impulse_of(r)); },
          "(m,) physical impulse, a copy: s / row_scale with restitution, else s [N s].")
      .def_property_readonly(
          "v",
          [](const HeldResult& r) -> py::object {
            if (!r->problem->has_velocities()) return py::none();
            return copy_of(body_velocities(*r->problem, r->solve.s));
          },
          "(n,) velocities of the bodies [m/s, rad/s], computed at each call; None without bodies.")
      .def_property_readonly(
          "multipliers",
          [](const HeldResult& r) -> py::object {
            if (!r->problem->equality) return py::none();
            return copy_of(multipliers(*r->problem, r->solve.s));
          },
          R"((p,) impulses of the equality rows, A v = A v_free + H s + G^T multipliers [N s], computed
at each call; the smallest where rows depend on each other; None without G.)")
      .def_property_readonly(
          "equality_residual",
          [](const PythonResult& r) { return equality_residual(*r.problem, r.solve.s); },
          "Largest of |G v - b| [m/s]; 0 without G.")
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
      .def("__bool__", [](const PythonResult& r) { return is_success(r.solve.status); })
      .def("__reduce__",
           [](const PythonResult& r) {
             return py::make_tuple(py::module_::import("bipot._pickle").attr("result_of"),
                                   py::make_tuple(parts_of_result(r)));
           })
      .def("__copy__", [](const HeldResult& r) { return r; })
      .def("__deepcopy__", [](const HeldResult& r, const py::dict&) { return r; })
      .def("__repr__", &representation);
}

py::dict to_dict(const ParameterSpec& spec) {
  py::dict row;
  row["name"] = spec.name;
  constexpr const char* kKinds[] = {"number", "integer", "choice", "text"};
  row["kind"] = kKinds[static_cast<int>(spec.kind)];
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
    py::list parameters;
    for (const ParameterSpec& spec : all_parameters(entry)) parameters.append(to_dict(spec));
    rows.append(py::dict(py::arg("name") = entry.name, py::arg("summary") = entry.summary,
                         py::arg("max_dim") = entry.max_dim,
                         py::arg("max_contacts") = entry.max_contacts,
                         py::arg("parameters") = parameters));
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
  module.def("solve_all", &solve_all, py::arg("problems"), py::arg("solver"), py::arg("tol"),
             py::arg("s0"), py::arg("time_limit"), py::arg("stop"), py::arg("max_iterations"),
             py::arg("parameters"), py::arg("threads"));
  module.def("_result_of_parts", &result_of_parts, py::arg("parts"));
  module.def("solvers", &list_solvers);
  module.def("parameter_names", &parameter_names, py::arg("solver"));
}

}  // namespace bipot
