#include "bench/python/python_watch.h"

#include <pybind11/pybind11.h>

#include <utility>

namespace bipot {

namespace py = pybind11;

bool PythonWatch::stopped() {
  if (stopped_) return true;
  const Clock::time_point now = Clock::now();
  if (now < next_) return false;
  const py::gil_scoped_acquire lock;
  if (PyErr_CheckSignals() != 0) keep(std::make_exception_ptr(py::error_already_set()));
  next_ = Clock::now() + kPause;
  return stopped_;
}

void PythonWatch::keep(std::exception_ptr thrown) {
  stopped_ = true;
  if (!thrown_) thrown_ = std::move(thrown);
}

void PythonWatch::rethrow() const {
  if (thrown_) std::rethrow_exception(thrown_);
}

}  // namespace bipot
