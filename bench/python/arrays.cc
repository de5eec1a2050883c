#include "bench/python/arrays.h"

#include <string>

namespace bipot {
namespace {

namespace py = pybind11;

py::module_ conversions() { return py::module_::import("bipot._arrays"); }

/// From (rows, columns, indptr, indices, data) as returned by bipot/_arrays.py: 32-bit indices,
/// sorted, within bounds.
template <class Sparse>
Sparse to_sparse(py::handle given, std::string_view name, const char* form) {
  const py::tuple parts = conversions().attr("matrix")(given, std::string(name), form);
  const auto indptr = parts[2].cast<py::array_t<int, py::array::c_style>>();
  const auto indices = parts[3].cast<py::array_t<int, py::array::c_style>>();
  const auto data = parts[4].cast<py::array_t<double, py::array::c_style>>();
  return Eigen::Map<const Sparse>(parts[0].cast<Eigen::Index>(), parts[1].cast<Eigen::Index>(),
                                  data.size(), indptr.data(), indices.data(), data.data());
}

template <class Sparse>
py::object to_scipy(const Sparse& matrix, py::handle owner, const char* kind) {
  const Eigen::Index count = matrix.outerIndexPtr()[matrix.outerSize()];
  const py::tuple parts = py::make_tuple(
      view_of(matrix.valuePtr(), count, owner), view_of(matrix.innerIndexPtr(), count, owner),
      view_of(matrix.outerIndexPtr(), matrix.outerSize() + 1, owner));
  return py::module_::import("scipy.sparse")
      .attr(kind)(parts, py::arg("shape") = py::make_tuple(matrix.rows(), matrix.cols()),
                  py::arg("copy") = false);
}

}  // namespace

Vector to_vector(py::handle array_like, std::string_view name) {
  const auto array = conversions()
                         .attr("vector")(array_like, std::string(name))
                         .cast<py::array_t<double, py::array::c_style>>();
  return Eigen::Map<const Vector>(array.data(), array.size());
}

SparseMatrix to_columns(py::handle matrix, std::string_view name) {
  return to_sparse<SparseMatrix>(matrix, name, "csc");
}
SparseRows to_rows(py::handle matrix, std::string_view name) {
  return to_sparse<SparseRows>(matrix, name, "csr");
}

py::object scipy_view(const SparseMatrix& matrix, py::handle owner) {
  return to_scipy(matrix, owner, "csc_matrix");
}
py::object scipy_view(const SparseRows& matrix, py::handle owner) {
  return to_scipy(matrix, owner, "csr_matrix");
}

}  // namespace bipot
