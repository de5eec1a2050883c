#include "bench/python/arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "core/base/triplets.h"

namespace bipot {
namespace {

namespace py = pybind11;
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Indices = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

constexpr std::int64_t kLargest = std::numeric_limits<int>::max();

std::string text_of(const py::object& x) { return py::str(x).cast<std::string>(); }

bool is_plain(py::handle x) {
  return PyFloat_CheckExact(x.ptr()) || PyLong_CheckExact(x.ptr()) ||
         Py_TYPE(x.ptr()) == py::detail::npy_api::get().PyArray_Type_;
}

/// True if numpy would lose a mask that hides something; lists are searched for masked rows.
bool hides_entries(py::handle x, int depth = 0) {
  if (is_plain(x)) return false;
  if (PyList_CheckExact(x.ptr()) || PyTuple_CheckExact(x.ptr())) {
    if (depth == 2) return false;
    for (const py::handle item : py::reinterpret_borrow<py::sequence>(x)) {
      if (hides_entries(item, depth + 1)) return true;
    }
    return false;
  }
  const py::module_ masked = py::module_::import("numpy.ma");
  return py::isinstance(x, masked.attr("MaskedArray")) && masked.attr("is_masked")(x).cast<bool>();
}

void require_real(const py::dtype& type, std::string_view name) {
  if (std::string_view("fiub").find(type.kind()) != std::string_view::npos) return;
  throw py::type_error(fmt::format("{} has dtype {}, expected real numbers", name, text_of(type)));
}

/// As numpy's array of real numbers, without a copy if there is one.
py::array real_array(py::handle given, std::string_view name) {
  if (hides_entries(given)) {
    throw std::invalid_argument(fmt::format("{} has masked entries: give a number for each", name));
  }
  try {
    py::array array(py::reinterpret_borrow<py::object>(given));
    require_real(array.dtype(), name);
    return array;
  } catch (const py::error_already_set& e) {
    if (!e.matches(PyExc_ValueError)) throw;
    throw std::invalid_argument(fmt::format("{}: {}", name, text_of(e.value())));
  }
}

std::string shape_of(const py::array& array) { return text_of(array.attr("shape")); }

void require_extent(std::int64_t rows, std::int64_t columns, std::int64_t entries,
                    std::string_view name) {
  if (std::min({rows, columns, entries}) >= 0 && std::max({rows, columns, entries}) <= kLargest) {
    return;
  }
  throw std::invalid_argument(
      fmt::format("{} is {} x {} with {} entries, at most {} of each can be stored", name, rows,
                  columns, entries, kLargest));
}

[[noreturn]] void throw_unsound(std::string_view name, std::string_view what) {
  throw std::invalid_argument(fmt::format("{} is not a sound sparse matrix: {}", name, what));
}

Indices to_indices(py::handle given, std::string_view name, const char* what) {
  const py::array array(py::reinterpret_borrow<py::object>(given));
  const char kind = array.dtype().kind();
  if ((kind != 'i' && kind != 'u') || array.ndim() != 1) {
    throw_unsound(name, fmt::format("{} is no list of integers", what));
  }
  return Indices(array);
}

Numbers to_entries(py::handle given, std::string_view name) {
  const Numbers entries(real_array(given, name));
  if (entries.ndim() != 1) throw_unsound(name, "data has not one dimension");
  return entries;
}

template <class Sparse>
Sparse without_zeros(Sparse made) {
  made.prune([](Eigen::Index, Eigen::Index, double value) { return value != 0; });
  return made;
}

/// The entries of compressed rows or columns, checked.
Triplets compressed_entries(std::int64_t rows, std::int64_t columns, bool by_rows,
                            const Indices& indptr, const Indices& indices, const Numbers& data,
                            std::string_view name) {
  const std::int64_t outer = by_rows ? rows : columns, inner = by_rows ? columns : rows;
  if (indptr.size() != outer + 1 || indptr.data()[0] != 0) {
    throw_unsound(name,
                  fmt::format("indptr has size {}, expected {} from 0", indptr.size(), outer + 1));
  }
  const std::int64_t stored = std::min(indices.size(), data.size());
  Triplets triplets;
  triplets.reserve(to_size(stored));
  for (std::int64_t k = 0; k < outer; ++k) {
    const std::int64_t begin = indptr.data()[k], end = indptr.data()[k + 1];
    if (begin > end || end > stored) {
      throw_unsound(name, fmt::format("indptr[{}] = {} after {}, with {} entries", k + 1, end,
                                      begin, stored));
    }
    for (std::int64_t at = begin; at < end; ++at) {
      const std::int64_t index = indices.data()[at];
      if (index < 0 || index >= inner) {
        throw_unsound(name,
                      fmt::format("indices[{}] = {}, expected 0 to {}", at, index, inner - 1));
      }
      const int i = static_cast<int>(k), j = static_cast<int>(index);
      triplets.emplace_back(by_rows ? i : j, by_rows ? j : i, data.data()[at]);
    }
  }
  return triplets;
}

template <class Sparse>
Sparse from_scipy(py::handle given, std::string_view name) {
  const py::tuple shape = given.attr("shape");
  if (shape.size() != 2) {
    throw std::invalid_argument(
        fmt::format("{} has shape {}, expected a matrix", name, text_of(shape)));
  }
  const auto rows = shape[0].cast<std::int64_t>(), columns = shape[1].cast<std::int64_t>();
  require_extent(rows, columns, given.attr("nnz").cast<std::int64_t>(), name);
  const auto format = given.attr("format").cast<std::string>();
  if (format == "csr" || format == "csc") {
    return without_zeros(
        from_triplets<Sparse>(rows, columns,
                              compressed_entries(rows, columns, format == "csr",
                                                 to_indices(given.attr("indptr"), name, "indptr"),
                                                 to_indices(given.attr("indices"), name, "indices"),
                                                 to_entries(given.attr("data"), name), name)));
  }
  const py::object coo = given.attr("tocoo")();
  const Indices row = to_indices(coo.attr("row"), name, "row");
  const Indices column = to_indices(coo.attr("col"), name, "col");
  const Numbers data = to_entries(coo.attr("data"), name);
  if (row.size() != data.size() || column.size() != data.size()) {
    throw_unsound(name, "row, col and data differ in size");
  }
  Triplets triplets;
  triplets.reserve(to_size(data.size()));
  for (py::ssize_t k = 0; k < data.size(); ++k) {
    const std::int64_t i = row.data()[k], j = column.data()[k];
    if (i < 0 || i >= rows || j < 0 || j >= columns) {
      throw_unsound(name, fmt::format("entry ({}, {}) of {} x {}", i, j, rows, columns));
    }
    triplets.emplace_back(static_cast<int>(i), static_cast<int>(j), data.data()[k]);
  }
  return without_zeros(from_triplets<Sparse>(rows, columns, triplets));
}

template <class Sparse>
Sparse from_dense(py::handle given, std::string_view name) {
  const py::array array = real_array(given, name);
  if (array.ndim() != 2) {
    throw std::invalid_argument(
        fmt::format("{} has shape {}, expected a matrix", name, shape_of(array)));
  }
  require_extent(array.shape(0), array.shape(1), 0, name);  // before a copy of other strides
  const Numbers rows(array);
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
      dense(rows.data(), rows.shape(0), rows.shape(1));
  require_extent(dense.rows(), dense.cols(), (dense.array() != 0).count(), name);
  return dense.sparseView();
}

/// Looks like a matrix of scipy.sparse: the module itself is not needed for it.
template <class Sparse>
Sparse to_sparse(py::handle given, std::string_view name) {
  if (!is_plain(given) && py::hasattr(given, "tocoo")) return from_scipy<Sparse>(given, name);
  return from_dense<Sparse>(given, name);
}

}  // namespace

Vector to_vector(py::handle array_like, std::string_view name) {
  const py::array array = real_array(array_like, name);
  if (array.ndim() != 1) {
    throw std::invalid_argument(
        fmt::format("{} has shape {}, expected one dimension", name, shape_of(array)));
  }
  const Numbers numbers(array);
  return Eigen::Map<const Vector>(numbers.data(), numbers.size());
}

double to_number(py::handle number, std::string_view name) {
  if (!py::isinstance<py::str>(number) && !PyBool_Check(number.ptr())) {
    const double value = PyFloat_AsDouble(number.ptr());
    if (PyErr_Occurred() == nullptr) return value;
    PyErr_Clear();
  }
  throw py::type_error(fmt::format("{}: expected a number, got {} {}", name,
                                   text_of(py::type::of(number).attr("__name__")),
                                   text_of(py::repr(number))));
}

SparseMatrix to_columns(py::handle matrix, std::string_view name) {
  return to_sparse<SparseMatrix>(matrix, name);
}
SparseRows to_rows(py::handle matrix, std::string_view name) {
  return to_sparse<SparseRows>(matrix, name);
}

template <class Sparse>
py::tuple parts_of(const Sparse& matrix) {
  const Eigen::Index count = matrix.nonZeros();
  return py::make_tuple(matrix.rows(), matrix.cols(),
                        py::array_t<int>(matrix.outerSize() + 1, matrix.outerIndexPtr()),
                        py::array_t<int>(count, matrix.innerIndexPtr()),
                        py::array_t<double>(count, matrix.valuePtr()));
}

template <class Sparse>
Sparse from_parts(const py::tuple& parts, std::string_view name) {
  const auto rows = parts[0].cast<std::int64_t>(), columns = parts[1].cast<std::int64_t>();
  const Numbers data = to_entries(parts[4], name);
  require_extent(rows, columns, data.size(), name);
  return from_triplets<Sparse>(
      rows, columns,
      compressed_entries(rows, columns, Sparse::IsRowMajor, to_indices(parts[2], name, "indptr"),
                         to_indices(parts[3], name, "indices"), data, name));
}

template <class Sparse>
py::object scipy_view(const Sparse& matrix, py::handle owner) {
  const Eigen::Index count = matrix.outerIndexPtr()[matrix.outerSize()];
  const py::tuple parts = py::make_tuple(
      view_of(matrix.valuePtr(), count, owner), view_of(matrix.innerIndexPtr(), count, owner),
      view_of(matrix.outerIndexPtr(), matrix.outerSize() + 1, owner));
  return py::module_::import("scipy.sparse")
      .attr(Sparse::IsRowMajor ? "csr_matrix" : "csc_matrix")(
          parts, py::arg("shape") = py::make_tuple(matrix.rows(), matrix.cols()),
          py::arg("copy") = false);
}

template py::tuple parts_of(const SparseMatrix&);
template py::tuple parts_of(const SparseRows&);
template SparseMatrix from_parts(const py::tuple&, std::string_view);
template SparseRows from_parts(const py::tuple&, std::string_view);
template py::object scipy_view(const SparseMatrix&, py::handle);
template py::object scipy_view(const SparseRows&, py::handle);

}  // namespace bipot
