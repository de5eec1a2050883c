#include <pybind11/stl.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>
#include <vector>

#include "bench/python/bindings.h"
#include "bench/python/python_watch.h"
#include "bench/tradeoff/advice_report.h"
#include "bench/tradeoff/advise.h"
#include "core/scene_files/scene_file.h"
#include "solvers/simulation/scene_start.h"

namespace bipot {
namespace {

namespace py = pybind11;

/// The advice as JSON text (keys: data/manual/reference/files.md).
std::string advise_scene(const std::string& name, const std::map<std::string, double>& goal,
                         const std::vector<std::string>& solvers, double time_limit, double window,
                         int samples, bool keep_step) {
  PythonWatch watch;
  Advice::Options options;
  for (const auto& [m, key, text] : Accuracy::kMeasures) {
    if (const auto asked = goal.find(key); asked != goal.end()) options.goal.*m = asked->second;
  }
  for (const std::string& solver : solvers) options.solvers.push_back({solver, solver, {}});
  options.time_limit = time_limit;
  options.window = window;
  options.samples = samples;
  options.keep_step = keep_step;
  options.interrupted = [&watch] { return watch.stopped(); };
  AnyScene scene = read_any_scene(scene_path(name));
  std::visit([](auto& any) { check_start(any, python_warnings()); }, scene);
  std::string json;
  {
    const py::gil_scoped_release release;
    Advice advice = bipot::advise(scene, options);
    advice.scene = name;
    json = json_text(to_json(advice, provenance("advise", "bipot.advise")));
  }
  watch.rethrow();
  return json;
}

}  // namespace

void bind_advise(py::module_& module) {
  module.def("advise", &advise_scene, py::arg("scene"), py::arg("goal"), py::arg("solvers"),
             py::arg("time_limit"), py::arg("window"), py::arg("samples"), py::arg("keep_step"));
}

}  // namespace bipot
