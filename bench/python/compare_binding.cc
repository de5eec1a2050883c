#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "bench/compare/comparison.h"
#include "bench/compare/comparison_report.h"
#include "bench/compare/comparison_rows.h"
#include "bench/measure/problem_target.h"
#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "bench/python/callable_solver.h"
#include "bench/python/python_watch.h"
#include "bench/report/chart.h"
#include "core/base/file_error.h"
#include "core/base/interrupt.h"

namespace bipot {
namespace {

namespace py = pybind11;

/// A finished comparison, and the data on its making for the report.
struct PythonComparison {
  Comparison comparison;
  ReportContext context;
};

ProblemSource source_of(const std::string& name, const PythonProblem& given, Vector start) {
  ProblemSource source;
  source.name = source.target = name;
  source.load = [problem = given.problem, start = std::move(start)] {
    TestProblem made{
        .origin = "a problem that Python handed over", .problem = *problem, .start = start};
    return made;
  };
  return source;
}

TargetOptions target_options(int scene_problems, const py::object& scene_steps,
                             PythonWatch& watch) {
  TargetOptions options{.scene_problems = scene_problems,
                        .cancelled = [&watch] { return watch.stopped(); },
                        .warn = python_warnings()};
  if (!scene_steps.is_none()) options.scene_steps = scene_steps.cast<int>();
  return options;
}

/// From strings, which are targets of `bipot compare`, and tuples (name, Problem, start or None).
std::vector<ProblemSource> sources_of(const py::list& given, const TargetOptions& scenes) {
  std::vector<ProblemSource> sources;
  for (const py::handle item : given) {
    if (py::isinstance<py::str>(item)) {
      for (ProblemSource& s : expand_targets({item.cast<std::string>()}, scenes)) {
        sources.push_back(std::move(s));
      }
      continue;
    }
    const auto [name, problem, start] =
        item.cast<std::tuple<std::string, std::shared_ptr<PythonProblem>, py::object>>();
    sources.push_back(
        source_of(name, *problem, start.is_none() ? Vector() : to_vector(start, "start")));
  }
  std::set<std::string> names;
  for (const ProblemSource& source : sources) {
    if (!names.insert(source.name).second) {
      throw std::invalid_argument(
          fmt::format("two problems are called {}; name them apart", source.name));
    }
  }
  return sources;
}

py::dict to_dict(const Comparison::Row& row) {
  py::dict out;
  for (const ComparisonColumn& column : comparison_columns()) {
    out[py::str(column.column.key)] = py::cast(column.cell(row).value);
  }
  return out;
}

/// Name to list of values, the cold rows first.
py::dict columns_of(const PythonComparison& self) {
  py::dict out;
  for (const ComparisonColumn& column : comparison_columns()) {
    out[py::str(column.column.key)] = py::list();
  }
  for (const auto* rows : {&self.comparison.rows, &self.comparison.warm_rows}) {
    for (const Comparison::Row& row : *rows) {
      for (const auto& [name, value] : to_dict(row)) out[name].attr("append")(value);
    }
  }
  return out;
}

/// Reports the rows of a comparison to Python as they are made.
void report_rows_to(const py::object& on_row, PythonWatch& watch, Comparison::Options& options) {
  if (on_row.is_none()) return;
  options.on_row = [&](const Comparison::Row& row, int done, int total) {
    const py::gil_scoped_acquire lock;
    try {
      on_row(to_dict(row), done, total);
    } catch (const py::error_already_set&) {
      watch.keep(std::current_exception());
    }
  };
}

PythonComparison run_comparison(const py::list& targets, std::vector<std::string> solvers,
                                const py::list& callables, std::vector<double> tols,
                                double time_limit, double reference_time_limit, int repeat,
                                double min_time, bool try_all, bool warm,
                                const std::filesystem::path& out, int scene_problems,
                                const py::object& scene_steps, const py::object& on_row,
                                const std::string& command) {
  PythonWatch watch;
  std::vector<std::unique_ptr<CallableSolver>> foreign;
  PythonComparison made;
  Comparison::Options& options = made.context.options;
  for (const py::handle item : callables) {
    auto [name, callable] = item.cast<std::pair<std::string, py::object>>();
    foreign.push_back(std::make_unique<CallableSolver>(name, callable, watch));
    options.foreign.push_back(foreign.back()->entry());
  }
  options.solvers = std::move(solvers);
  options.tols = std::move(tols);
  options.time_limit = time_limit;
  options.reference_time_limit = reference_time_limit;
  options.repeat = repeat;
  options.min_time = min_time;
  options.try_all = try_all;
  options.warm = warm;
  options.out = out;
  options.watch.interrupted = [&watch] { return watch.stopped(); };
  report_rows_to(on_row, watch, options);
  const std::vector<ProblemSource> sources =
      sources_of(targets, target_options(scene_problems, scene_steps, watch));
  {
    const py::gil_scoped_release release;
    made.comparison = compare(sources, options);
  }
  watch.rethrow();
  // The options as the report shows them; none of them runs again.
  options.foreign.clear();
  options.on_row = nullptr;
  options.watch = {};
  made.context.made = provenance("compare", command);
  made.context.command_of_target = "bipot.compare([\"{}\"], ...)";
  return made;
}

void write_into(const PythonComparison& self, const std::filesystem::path& folder) {
  const py::gil_scoped_release release;
  require_plotting_tool();
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) throw FileError(folder, "", failed.message());
  write_report(folder, self.comparison, self.context);
}

std::vector<std::shared_ptr<PythonProblem>> load_problems(const std::vector<std::string>& targets,
                                                          int scene_problems,
                                                          const py::object& scene_steps) {
  PythonWatch watch;
  const std::vector<ProblemSource> sources =
      expand_targets(targets, target_options(scene_problems, scene_steps, watch));
  std::vector<std::shared_ptr<PythonProblem>> problems;
  try {
    const py::gil_scoped_release release;
    for (const ProblemSource& source : sources) {
      TestProblem made = source.load();
      problems.push_back(std::make_shared<PythonProblem>(std::move(made.problem), source.name));
      if (made.start.size() > 0) problems.back()->guesses.push_back(std::move(made.start));
    }
  } catch (const Interrupted&) {
  }
  watch.rethrow();
  return problems;
}

}  // namespace

void bind_compare(py::module_& module) {
  py::class_<PythonComparison> comparison(module, "Comparison");
  refuse_new(comparison);
  comparison
      .def_property_readonly("complete",
                             [](const PythonComparison& self) { return self.comparison.complete; })
      .def("columns", &columns_of)
      .def("text", [](const PythonComparison& self) { return to_text(self.comparison); })
      .def("json",
           [](const PythonComparison& self) {
             return json_text(to_json(self.comparison, self.context));
           })
      .def("report", &write_into, py::arg("folder"));
  module.def("compare", &run_comparison, py::arg("targets"), py::arg("solvers"),
             py::arg("callables"), py::arg("tols"), py::arg("time_limit"),
             py::arg("reference_time_limit"), py::arg("repeat"), py::arg("min_time"),
             py::arg("try_all"), py::arg("warm"), py::arg("out"), py::arg("scene_problems"),
             py::arg("scene_steps"), py::arg("on_row"), py::arg("command"));
  module.def("name_of_callable", &name_of_callable, py::arg("callable"));
  module.def("problems", &load_problems, py::arg("targets"), py::arg("scene_problems"),
             py::arg("scene_steps"));
}

}  // namespace bipot
