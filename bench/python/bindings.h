#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/motion/state.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// A Problem in Python: sound and constant, so that arrays can refer to it and solves can run on it
/// beside Python code.
struct PythonProblem {
  std::shared_ptr<const ContactProblem> problem;
  std::string name;             ///< for readers; empty: none
  std::string caution;          ///< why W is no Delassus operator, if that was accepted
  Vector solution;              ///< reference of the file that it was read from; empty: none
  std::vector<Vector> guesses;  ///< likewise, impulses to start from
  Vector restitution;           ///< of each row, where it was given with physical data; else empty

  PythonProblem() = default;  ///< the problem is to be set
  explicit PythonProblem(std::shared_ptr<const ContactProblem> p) : problem(std::move(p)) {}
  explicit PythonProblem(ContactProblem p, std::string called = {})
      : problem(std::make_shared<const ContactProblem>(std::move(p))), name(std::move(called)) {}
};

/// A constant snapshot of the state between two steps: State and SphereState of Python.
template <int D>
struct PythonState {
  State<D> state;
};

/// "fixed", "moving" or "driven".
template <int D>
std::string motion_name(typename Wall<D>::Motion motion);

/// The walls as dictionaries; State.walls of Python has the keys.
template <int D>
pybind11::list walls_of(const State<D>& state);

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
