#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "bench/python/python_problem.h"
#include "core/base/file_error.h"
#include "core/base/nearest_name.h"
#include "core/problem/delassus.h"
#include "core/problem_files/fclib_file.h"
#include "core/problem_files/problem_file.h"

namespace bipot {
namespace {

namespace py = pybind11;
using HeldProblem = std::shared_ptr<PythonProblem>;

/// d from the sizes if it is not given; with it, mu may be one number for all contacts.
int infer_dim(const py::object& given, Eigen::Index rows, Vector& mu, bool one_mu) {
  if (!given.is_none()) {
    if (PyIndex_Check(given.ptr()) == 0) throw py::type_error("dim: expected 1, 2 or 3");
    const int dim = py::int_(given).cast<int>();
    if (dim < 1 || dim > 3) {
      throw std::invalid_argument(fmt::format("dim = {}, expected 1, 2 or 3", dim));
    }
    if (!one_mu) return dim;
    if (rows % dim != 0) {
      throw std::invalid_argument(
          fmt::format("u_free has size {}, expected a multiple of dim = {}", rows, dim));
    }
    mu = Vector::Constant(rows / dim, mu[0]);
    return dim;
  }
  if (one_mu) {
    throw std::invalid_argument(
        "dim cannot be inferred from a single mu: give one for each contact, or dim");
  }
  const Eigen::Index contacts = mu.size();
  if (contacts == 0) {
    throw std::invalid_argument("dim cannot be inferred without contacts: give dim");
  }
  if (rows % contacts != 0 || rows / contacts < 1 || rows / contacts > 3) {
    throw std::invalid_argument(
        fmt::format("u_free has size {}, expected {}, {} or {}: 1, 2 or 3 rows for each of the {} "
                    "contacts of mu",
                    rows, contacts, 2 * contacts, 3 * contacts, contacts));
  }
  return static_cast<int>(rows / contacts);
}

/// Both or neither of the bodies' matrices, W or these.
void require_a_form(const py::object& A, const py::object& H, const py::object& W,
                    const py::object& v_free) {
  if (A.is_none() != H.is_none()) {
    throw std::invalid_argument(A.is_none() ? "H is given without A" : "A is given without H");
  }
  if (A.is_none() && W.is_none()) throw std::invalid_argument("neither W nor (A, H) is given");
  if (A.is_none() != v_free.is_none()) {
    throw std::invalid_argument(A.is_none() ? "v_free is given without A and H"
                                            : "v_free is missing beside A and H");
  }
}

/// The value of an option; None if it is not given.
py::object option(const py::kwargs& options, const char* name) {
  return options.contains(name) ? py::object(options[name]) : py::object(py::none());
}

void refuse_unknown(const py::kwargs& options) {
  const std::vector<std::string> valid = {"A",  "H",   "W",         "v_free", "u_free",
                                          "mu", "dim", "row_scale", "name"};
  for (const auto& [key, value] : options) {
    const auto name = key.cast<std::string>();
    if (std::find(valid.begin(), valid.end(), name) == valid.end()) {
      throw py::type_error(unknown_name_message("option", name, valid));
    }
  }
}

HeldProblem make_problem(const py::kwargs& options) {
  refuse_unknown(options);
  const py::object A = option(options, "A"), H = option(options, "H"), W = option(options, "W");
  const py::object v_free = option(options, "v_free"), u_free = option(options, "u_free");
  const py::object mu = option(options, "mu"), row_scale = option(options, "row_scale");
  require_a_form(A, H, W, v_free);
  ContactProblem p;
  if (!A.is_none()) {
    p.A = to_columns(A, "A");
    p.H = to_columns(H, "H");
    p.v_free = to_vector(v_free, "v_free");
  }
  if (!W.is_none()) p.W = to_rows(W, "W");
  if (mu.is_none()) throw std::invalid_argument("mu is missing");
  if (!u_free.is_none()) {
    p.u_free = to_vector(u_free, "u_free");
  } else if (!A.is_none() && p.v_free.size() == p.H.rows()) {
    p.u_free = p.H.transpose() * p.v_free;
  } else {
    throw std::invalid_argument("u_free is missing");
  }
  const bool one_mu = py::module_::import("numpy").attr("ndim")(mu).cast<int>() == 0;
  p.mu = to_vector(one_mu ? py::object(py::make_tuple(mu)) : mu, "mu");
  p.dim = infer_dim(option(options, "dim"), p.u_free.size(), p.mu, one_mu);
  if (!row_scale.is_none()) p.row_scale = to_vector(row_scale, "row_scale");
  if (std::string defect = validate(p); !defect.empty()) throw std::invalid_argument(defect);
  // As for problems from files: with a general A the operator is W itself, assembled once for all.
  if (p.has_velocities() && !p.has_delassus() && p.num_rows() > 0 && !is_diagonal(p.A)) {
    try {
      p.W = assemble_delassus(p.A, p.H, p.dim);
    } catch (const std::runtime_error&) {
      throw std::invalid_argument("A is not positive definite");
    }
  }
  const py::object name = option(options, "name");
  return std::make_shared<PythonProblem>(std::move(p),
                                         name.is_none() ? "" : py::str(name).cast<std::string>());
}

HeldProblem read(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) {
    PyErr_SetString(PyExc_FileNotFoundError, (path.string() + ": no such file").c_str());
    throw py::error_already_set();
  }
  ProblemFile file;
  try {
    const py::gil_scoped_release release;
    file = read_problem(path);
  } catch (const FileError& e) {
    throw std::invalid_argument(e.what());  // readable, but not a problem
  }
  auto made = std::make_shared<PythonProblem>(std::move(file.problem), path.stem().string());
  if (file.r) made->solution = std::move(*file.r);
  made->guesses = std::move(file.guesses);
  return made;
}

void write(const PythonProblem& given, const std::filesystem::path& path, const py::object& s,
           const std::string& title, const std::string& description,
           const std::vector<py::object>& guesses) {
  std::vector<Vector> starts;
  for (const py::object& guess : guesses) starts.push_back(to_vector(guess, "guesses"));
  const Vector impulse = s.is_none() ? Vector() : to_vector(s, "s");
  const ContactProblem& p = *given.problem;
  if (!s.is_none() && impulse.size() != p.num_rows()) {
    throw std::invalid_argument(
        fmt::format("s has size {}, expected {}", impulse.size(), p.num_rows()));
  }
  const py::gil_scoped_release release;
  write_fclib(path, p, {.title = title, .description = description, .math_info = {}}, starts);
  if (impulse.size() == 0) return;
  Vector u;
  DelassusOperator(p).velocity(impulse, u);
  write_fclib_solution(path, impulse, u);
}

/// W as scipy's csr_matrix: a view if the problem has it, else assembled now.
py::object delassus(const HeldProblem& self) {
  const ContactProblem& p = *self->problem;
  const py::object owner = py::cast(self);
  if (p.has_delassus() || p.num_rows() == 0) return scipy_view(p.W, owner);
  const auto assembled = [&p] {
    const py::gil_scoped_release release;
    return new SparseRows(assemble_delassus(p.A, p.H, p.dim));
  }();
  const py::capsule keeper(assembled, [](void* x) { delete static_cast<SparseRows*>(x); });
  return scipy_view(*assembled, keeper);
}

Vector checked_impulse(const ContactProblem& p, const py::object& s) {
  Vector x = to_vector(s, "s");
  if (x.size() != p.num_rows()) {
    throw std::invalid_argument(fmt::format("s has size {}, expected {}", x.size(), p.num_rows()));
  }
  return x;
}

py::object velocities(const PythonProblem& self, const py::object& s) {
  const ContactProblem& p = *self.problem;
  const Vector x = checked_impulse(p, s);
  Vector u(p.num_rows());
  {
    const py::gil_scoped_release release;
    DelassusOperator(p).velocity(x, u);
  }
  return copy_of(u);
}

py::object bodies(const PythonProblem& self, const py::object& s) {
  const ContactProblem& p = *self.problem;
  if (!p.has_velocities()) {
    throw std::invalid_argument("the problem is given by W alone: it has no bodies");
  }
  return copy_of(body_velocities(p, checked_impulse(p, s)));
}

/// A view of one of the vectors; None if it is empty and `optional`.
auto vector_property(Vector ContactProblem::*field, bool optional) {
  return [field, optional](const HeldProblem& self) -> py::object {
    const Vector& x = (*self->problem).*field;
    if (optional && x.size() == 0) return py::none();
    return view_of(x, py::cast(self));
  };
}

}  // namespace

void bind_problem(py::module_& module) {
  py::class_<PythonProblem, HeldProblem> problem(
      module, "Problem", R"(One frictional contact problem, checked and immutable.

Either bodies, A (n, n) symmetric positive definite [kg, kg m²], H (n, m) and v_free (n,)
[m/s, rad/s], or W (m, m) [1/kg], or both; u_free (m,) [m/s], H^T v_free where it is left out with
bodies; mu (c,), or one number with `dim`. Matrices are anything of scipy.sparse, or dense arrays;
duplicates are summed, explicit zeros dropped; integers and float32 become float64. Everything is
copied. dim (1, 2 or 3 rows a contact) is len(u_free) / len(mu) where it is not given.
row_scale (m,): sqrt(1 + e) of each row of a problem with restitution (data/manual/explanation/method.md).

Raises ValueError with the field and both sizes, or the entry and its value; TypeError for what is
no array of real numbers or an option that does not exist.

All arrays and matrices that it returns are read-only views into the problem, without copies,
but for `delassus()` where W must be assembled, `velocity` and `body_velocity`.)");
  problem.def(py::init(&make_problem));
  const auto matrix = [](const auto& m, bool there, const HeldProblem& self) -> py::object {
    if (!there) return py::none();
    return scipy_view(m, py::cast(self));
  };
  problem
      .def_property_readonly(
          "dim", [](const PythonProblem& self) { return self.problem->dim; },
          "d, rows of a contact: 1 (frictionless), 2 or 3.")
      .def_property_readonly(
          "num_contacts", [](const PythonProblem& self) { return self.problem->num_contacts(); },
          "c.")
      .def_property_readonly(
          "num_rows", [](const PythonProblem& self) { return self.problem->num_rows(); },
          "m = c d.")
      .def_property_readonly(
          "num_dofs", [](const PythonProblem& self) { return self.problem->num_dofs(); },
          "n, degrees of freedom of the bodies; 0 where the problem has W alone.")
      .def_readonly("name", &PythonProblem::name,
                    "For readers; the stem of the file that it was read from.")
      .def_property_readonly(
          "A",
          [matrix](const HeldProblem& self) {
            return matrix(self->problem->A, self->problem->has_velocities(), self);
          },
          "(n, n) mass matrix, csc_matrix of read-only views [kg, kg m²]; None without bodies.")
      .def_property_readonly(
          "H",
          [matrix](const HeldProblem& self) {
            return matrix(self->problem->H, self->problem->has_velocities(), self);
          },
          "(n, m) wrench map, csc_matrix of read-only views [-, m]; None without bodies.")
      .def_property_readonly(
          "W",
          [matrix](const HeldProblem& self) {
            return matrix(self->problem->W, self->problem->has_delassus(), self);
          },
          "As it was given; None where the problem has bodies alone, see `delassus`.")
      .def_property_readonly(
          "v_free", vector_property(&ContactProblem::v_free, true),
          "(n,) velocities without contact impulses [m/s, rad/s], a view; None without bodies.")
      .def_property_readonly("u_free", vector_property(&ContactProblem::u_free, false),
                             "(m,) value of u at s = 0 [m/s], read-only view.")
      .def_property_readonly("mu", vector_property(&ContactProblem::mu, false),
                             "(c,) friction coefficients [-], read-only view.")
      .def_property_readonly(
          "row_scale", vector_property(&ContactProblem::row_scale, true),
          "(m,) sqrt(1 + e) of each row [-], read-only view; None without restitution.")
      .def_property_readonly(
          "solution",
          [](const HeldProblem& self) -> py::object {
            if (self->solution.size() == 0) return py::none();
            return view_of(self->solution, py::cast(self));
          },
          "(m,) reference impulse of the file that it was read from [N s].")
      .def_property_readonly(
          "guesses",
          [](const HeldProblem& self) {
            py::list list;
            for (const Vector& x : self->guesses) {
              list.append(view_of(x, py::cast(self)));
            }
            return list;
          },
          "Impulses to start from, of the file or scene, each (m,) [N s].")
      .def("delassus", &delassus,
           "W = H^T A^-1 H (m, m) [1/kg], assembled where the problem does not have it.")
      .def("velocity", &velocities, py::arg("s"), "u = W s + u_free (m,) [m/s].")
      .def("body_velocity", &bodies, py::arg("s"),
           "v = v_free + A^-1 H s (n,) [m/s, rad/s]. Raises ValueError without bodies.")
      .def("__repr__", [](const PythonProblem& self) {
        const ContactProblem& p = *self.problem;
        return fmt::format("<bipot.Problem{}: {} contacts, d = {}{}>",
                           self.name.empty() ? "" : " " + self.name, p.num_contacts(), p.dim,
                           p.has_velocities() ? fmt::format(", {} degrees of freedom", p.num_dofs())
                                              : ", given by W");
      });
  module.def("read", &read, py::arg("path"));
  module.def("write", &write, py::arg("problem"), py::arg("path"), py::arg("s"), py::arg("title"),
             py::arg("description"), py::arg("guesses"));
}

}  // namespace bipot
