#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <functional>
#include <string>

namespace bipot {

/// The parts of the module. Arrays of constant data are read-only views; a view keeps its owner
/// alive.
void bind_problem(pybind11::module_& module);
void bind_solve(pybind11::module_& module);
void bind_judge(pybind11::module_& module);
void bind_compare(pybind11::module_& module);
void bind_state(pybind11::module_& module);
void bind_simulation(pybind11::module_& module);
void bind_advise(pybind11::module_& module);

/// Objects of the class are made by the module alone: `Class.__new__(Class)` would have no data.
void refuse_new(const pybind11::object& bound);

/// A contact's number; None for -1.
inline pybind11::object contact_or_none(int contact) {
  if (contact < 0) return pybind11::none();
  return pybind11::int_(contact);
}

/// Makes Python warnings of texts, each once. They name the line that called a function of the
/// package with @named_options. Call with Python's lock held; throws where a warning is an error.
std::function<void(const std::string&)> python_warnings();

/// find_scene(), but Python's FileNotFoundError for a file that does not exist.
std::filesystem::path scene_path(const std::string& path_or_name);

}  // namespace bipot
