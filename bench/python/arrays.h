#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <string_view>

#include "core/base/types.h"

namespace bipot {

/// One-dimensional read-only view of `size` values `stride` bytes apart; it keeps `owner` alive.
template <class Number>
pybind11::array view_of(const Number* data, Eigen::Index size, pybind11::handle owner,
                        Eigen::Index stride = sizeof(Number)) {
  pybind11::array array(pybind11::dtype::of<Number>(), {size}, {stride}, data, owner);
  array.attr("setflags")(pybind11::arg("write") = false);
  return array;
}

/// n x columns read-only view of vectors of doubles in consecutive structures.
inline pybind11::array view_of_rows(const double* data, Eigen::Index size, Eigen::Index columns,
                                    Eigen::Index stride, pybind11::handle owner) {
  pybind11::array array(pybind11::dtype::of<double>(), {size, columns},
                        {stride, Eigen::Index{sizeof(double)}}, data, owner);
  array.attr("setflags")(pybind11::arg("write") = false);
  return array;
}

inline pybind11::array view_of(const Vector& x, pybind11::handle owner) {
  return view_of(x.data(), x.size(), owner);
}

/// A copy that Python owns.
inline pybind11::array_t<double> copy_of(const Vector& x) {
  return pybind11::array_t<double>(x.size(), x.data());
}

/// A one-dimensional array-like of real numbers, copied. Throws TypeError or ValueError with the
/// name of the argument; masked entries are refused.
Vector to_vector(pybind11::handle array_like, std::string_view name);

/// A number. Throws TypeError for anything else, a text or a truth value included.
double to_number(pybind11::handle number, std::string_view name);

/// A matrix of scipy.sparse, or a two-dimensional array, copied with duplicates summed, explicit
/// zeros dropped and indices sorted. Throws as to_vector.
SparseMatrix to_columns(pybind11::handle matrix, std::string_view name);
SparseRows to_rows(pybind11::handle matrix, std::string_view name);

/// (rows, columns, indptr, indices, data), copies; and the matrix of such a tuple. Throws
/// std::invalid_argument.
template <class Sparse>
pybind11::tuple parts_of(const Sparse& matrix);
template <class Sparse>
Sparse from_parts(const pybind11::tuple& parts, std::string_view name);

/// scipy.sparse.csc_matrix or csr_matrix, of read-only views.
template <class Sparse>
pybind11::object scipy_view(const Sparse& matrix, pybind11::handle owner);

}  // namespace bipot
