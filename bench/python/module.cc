// The native part of the Python module `bipot`; the interface for users and its documentation are
// in bipot/.

#include <pybind11/stl.h>

#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>

#include "bench/problems/scene_catalogue.h"
#include "bench/python/bindings.h"
#include "core/base/file_error.h"
#include "core/base/nearest_name.h"
#include "core/base/version.h"
#include "core/scene_files/scene_file.h"

namespace py = pybind11;

void bipot::refuse_new(const py::object& bound) {
  const std::string name = py::str(bound.attr("__name__"));
  bound.attr("__new__") = py::cpp_function([name](const py::args&, const py::kwargs&) {
    throw py::type_error("bipot." + name + " is made by the functions of bipot alone");
  });
}

std::function<void(const std::string&)> bipot::python_warnings() {
  return [said = std::make_shared<std::set<std::string>>()](const std::string& text) {
    constexpr int kCaller = 3;  // of the function that the options' check calls
    if (said->insert(text).second && PyErr_WarnEx(PyExc_UserWarning, text.c_str(), kCaller) < 0) {
      throw py::error_already_set();
    }
  };
}

std::filesystem::path bipot::scene_path(const std::string& path_or_name) {
  try {
    return find_scene(path_or_name);
  } catch (const std::invalid_argument& e) {
    const std::filesystem::path path = path_or_name;
    const bool file = path.has_extension() || path.has_parent_path();
    if (!file || std::filesystem::exists(path)) throw;
    PyErr_SetString(PyExc_FileNotFoundError, e.what());
    throw py::error_already_set();
  }
}

PYBIND11_MODULE(_bipot, module) {
  module.doc() = "Native part of the package bipot.";
  // pybind11 passes it by value: NOLINTNEXTLINE(performance-unnecessary-value-param)
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const bipot::FileError& e) {
      PyErr_SetString(PyExc_OSError, e.what());
    } catch (const bipot::SceneFileError& e) {
      PyErr_SetString(PyExc_ValueError, e.what());
    }
  });
  module.attr("__version__") = bipot::program_version();
  module.def("unknown_name_message", &bipot::unknown_name_message, py::arg("kind"), py::arg("name"),
             py::arg("candidates"));
  bipot::bind_problem(module);
  bipot::bind_solve(module);
  bipot::bind_judge(module);
  bipot::bind_compare(module);
  bipot::bind_state(module);  // before its steps
  bipot::bind_simulation(module);
  bipot::bind_advise(module);
}
