#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "core/motion/state.h"

namespace bipot {

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

}  // namespace bipot
