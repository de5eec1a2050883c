#pragma once

#include <pybind11/pybind11.h>

namespace bipot {

/// The module's parts, by noun. Arrays that reach Python are read-only views wherever what they
/// show cannot change; a view keeps alive what it looks at.
void bind_problem(pybind11::module_& module);
void bind_solve(pybind11::module_& module);
void bind_judge(pybind11::module_& module);
void bind_compare(pybind11::module_& module);
void bind_simulation(pybind11::module_& module);
void bind_advise(pybind11::module_& module);

}  // namespace bipot
