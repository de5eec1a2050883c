#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "core/base/counted.h"
#include "core/base/file_error.h"
#include "core/files/atomic_file.h"
#include "core/problem/compliance.h"
#include "core/problem/delassus.h"
#include "core/problem/equality_rows.h"
#include "core/problem_files/fclib_file.h"
#include "core/problem_files/problem_file.h"

namespace bipot {
namespace {

namespace py = pybind11;
using HeldProblem = std::shared_ptr<PythonProblem>;
using ProblemClass = py::class_<PythonProblem, HeldProblem>;

/// d from the sizes if it is not given; with it, mu may be one number for all contacts.
int infer_dim(const py::object& given, Eigen::Index rows, Vector& mu, bool one_mu, bool rolls) {
  if (!given.is_none()) {
    if (PyIndex_Check(given.ptr()) == 0) throw py::type_error("dim: expected 1, 2 or 3");
    const int dim = py::int_(given).cast<int>();
    if ((dim < 1 || dim > 3) && !(rolls && dim == 6)) {
      throw std::invalid_argument(
          fmt::format("dim = {}, expected {}", dim, rolls ? "3 or 6 with mu_r" : "1, 2 or 3"));
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
  if (rolls && rows % contacts == 0 && rows / contacts == 6) return 6;
  if (rows % contacts != 0 || rows / contacts < 1 || rows / contacts > 3) {
    throw std::invalid_argument(
        fmt::format("u_free has size {}, expected {}, {} or {}: 1, 2 or 3 rows for each of the {} "
                    "contacts of mu",
                    rows, contacts, 2 * contacts, 3 * contacts, contacts));
  }
  return static_cast<int>(rows / contacts);
}

/// The value of an option; None if it is not given.
py::object option(const py::kwargs& options, const char* name) {
  return options.contains(name) ? py::object(options[name]) : py::object(py::none());
}

/// The value of an option that has two names.
py::object option(const py::kwargs& options, const char* name, const char* other) {
  py::object value = option(options, name), same = option(options, other);
  if (!value.is_none() && !same.is_none()) {
    throw std::invalid_argument(fmt::format("give {} or {}, not both", name, other));
  }
  return value.is_none() ? same : value;
}

/// Throws TypeError for a value without a keyword, or with one that is not valid.
void require_keywords(const py::args& arguments, const py::kwargs& options, const char* form,
                      std::initializer_list<std::string_view> valid) {
  if (arguments.size() > 0) throw py::type_error(fmt::format("expected keywords: {}", form));
  for (const auto& [key, value] : options) {
    if (std::ranges::find(valid, key.cast<std::string_view>()) != valid.end()) continue;
    py::list names;
    for (const std::string_view one : valid) names.append(py::str(one.data(), one.size()));
    py::module_::import("bipot._names").attr("refuse_unknown")(py::make_tuple(key), names);
  }
}

void require_size(const char* field, Eigen::Index size, Eigen::Index expected) {
  if (size == expected) return;
  throw std::invalid_argument(fmt::format("{} has size {}, expected {}", field, size, expected));
}

bool is_one_number(const py::object& x) {
  return PyFloat_Check(x.ptr()) != 0 || PyLong_Check(x.ptr()) != 0 ||
         (py::hasattr(x, "ndim") && x.attr("ndim").cast<int>() == 0);
}

/// One number, or an array-like.
Vector to_numbers(const py::object& x, const char* name) {
  return is_one_number(x) ? Vector::Constant(1, to_number(x, name)) : to_vector(x, name);
}

/// Both or neither of the bodies' matrices, W or these.
void require_a_form(const py::object& A, bool wrenches, const py::object& W,
                    const py::object& v_free) {
  if (A.is_none() == wrenches) {
    throw std::invalid_argument(A.is_none() ? "H is given without A" : "A is given without H");
  }
  if (A.is_none() && W.is_none()) throw std::invalid_argument("neither W nor (A, H) is given");
  if (A.is_none() != v_free.is_none()) {
    throw std::invalid_argument(A.is_none() ? "v_free is given without A and H"
                                            : "v_free is missing beside A and H");
  }
}

/// A and H, or the Jacobian J = Hᵀ in the place of H.
void take_bodies(ContactProblem& p, const py::object& A, const py::object& H, const py::object& J) {
  p.A = to_columns(A, "A");
  p.H = H.is_none() ? SparseMatrix(to_rows(J, "J").transpose()) : to_columns(H, "H");
  const Eigen::Index n = p.A.rows(), rows = p.H.rows(), columns = p.H.cols();
  if (rows == n || columns != n || p.A.cols() != n) return;
  throw std::invalid_argument(
      H.is_none()
          ? fmt::format("J is {0} x {1}, expected m x {0}; did you pass H = J^T? Give it as H=", n,
                        rows)
          : fmt::format("H is {1} x {0}, expected {0} x m; did you pass J = H^T? Give it as J=", n,
                        rows));
}

/// Hᵀ v in physical variables.
Vector at_contacts(const PythonProblem& given, const ContactProblem& p, const Vector& v,
                   const char* name) {
  require_size(name, v.size(), p.H.rows());
  Vector u = p.H.transpose() * v;
  if (given.restitution.size() > 0) u = u.cwiseProduct(p.row_scale);
  return u;
}

/// Coefficients of restitution by row, from one number or one for each contact (their normals),
/// or one for each row.
Vector restitution_by_row(const py::object& given, const ContactProblem& p) {
  const Vector e = to_numbers(given, "restitution");
  const Eigen::Index contacts = p.num_contacts(), rows = p.num_rows();
  if (!((e.array() >= 0) && (e.array() <= 1)).all()) {
    throw std::invalid_argument("restitution: expected numbers from 0 to 1");
  }
  if (e.size() == rows) return e;
  if (e.size() != 1 && e.size() != contacts) {
    throw std::invalid_argument(
        fmt::format("restitution has size {}, expected 1, {} or {}", e.size(), contacts, rows));
  }
  Vector by_row = Vector::Zero(rows);
  for (Eigen::Index c = 0; c < contacts; ++c) by_row[c * p.dim] = e[e.size() == 1 ? 0 : c];
  return by_row;
}

bool has_velocities_before(const py::kwargs& options) {
  return !option(options, "v_before", "u_before").is_none();
}

/// Value of u at s = 0 in the symmetric variables (data/manual/explanation/method.md, §3), from the
/// physical one and the velocities before the impact. `dofs`: those given; compliance adds more,
/// which are at rest.
Vector symmetric_velocity(const PythonProblem& given, const ContactProblem& p,
                          const py::kwargs& options, Eigen::Index dofs) {
  const py::object at_bodies = option(options, "v_before");
  const py::object before = option(options, "v_before", "u_before");
  if (before.is_none()) {
    throw std::invalid_argument(
        "restitution needs the velocities before the impact: v_before (n) or u_before (m)");
  }
  Vector u = to_vector(before, at_bodies.is_none() ? "u_before" : "v_before");
  if (!at_bodies.is_none()) {
    if (u.size() == dofs) u.conservativeResizeLike(Vector::Zero(p.H.rows()));
    u = at_contacts(given, p, u, "v_before");
  }
  require_size("u_before", u.size(), p.num_rows());
  return (p.u_free + given.restitution.cwiseProduct(u)).cwiseQuotient(p.row_scale);
}

/// From physical friction to that of the symmetric variables. `row`: the first that it bounds.
void scale_friction(const ContactProblem& p, int row, Vector& coefficients) {
  for (Eigen::Index c = 0; p.dim > 1 && c < coefficients.size(); ++c) {
    coefficients[c] *= p.row_scale[c * p.dim + row] / p.row_scale[c * p.dim];
  }
}

/// A coefficient of rolling: one number, or one for each contact.
Vector rolling_coefficient(const py::object& given, const char* name, Eigen::Index contacts) {
  if (given.is_none()) return {};
  Vector values = to_numbers(given, name);
  if (is_one_number(given)) values = Vector::Constant(contacts, values[0]);
  return values;
}

/// From physical variables to the symmetric ones.
void take_restitution(PythonProblem& given, ContactProblem& p, const py::kwargs& options,
                      Eigen::Index dofs) {
  given.restitution = restitution_by_row(option(options, "restitution", "e"), p);
  p.row_scale = (1 + given.restitution.array()).sqrt();
  const Vector inverse = p.row_scale.cwiseInverse();
  for (int k = 0; k < p.H.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator it(p.H, k); it; ++it) it.valueRef() *= inverse[it.col()];
  }
  for (int k = 0; k < p.W.outerSize(); ++k) {
    for (SparseRows::InnerIterator it(p.W, k); it; ++it) {
      it.valueRef() *= inverse[it.row()] * inverse[it.col()];
    }
  }
  p.u_free = symmetric_velocity(given, p, options, dofs);
  scale_friction(p, 1, p.mu);
  scale_friction(p, p.plain_dim(), p.mu_r);
  scale_friction(p, p.dim - 1, p.mu_spin);
}

void require_sound(const std::string& defect) {
  if (!defect.empty()) throw std::invalid_argument(defect);
}

/// b of the equality rows; 0 where it is not given.
Vector equality_values(const py::object& b, const SparseRows& G) {
  return b.is_none() ? Vector(Vector::Zero(G.rows())) : to_vector(b, "b");
}

/// Eliminates the equality rows, if any are given.
ContactProblem with_joints(ContactProblem p, const py::kwargs& options) {
  const py::object G = option(options, "G"), b = option(options, "b");
  if (G.is_none() && !b.is_none()) {
    throw std::invalid_argument("b is given without G; u at s = 0 is u_free");
  }
  if (G.is_none()) return p;
  if (p.has_delassus()) throw std::invalid_argument("W is given with G: give A and H alone");
  SparseRows rows = to_rows(G, "G");
  Vector values = equality_values(b, rows);
  const py::gil_scoped_release release;
  return with_equality_rows(std::move(p), std::move(rows), std::move(values));
}

/// R by its diagonal, or as a matrix.
SparseRows compliance(const py::object& given) {
  const auto array = py::array::ensure(given);
  if (!array || array.ndim() != 1) return to_rows(given, "R");
  const Vector diagonal = to_vector(given, "R");
  SparseRows R(diagonal.size(), diagonal.size());
  for (Eigen::Index row = 0; row < diagonal.size(); ++row) R.insert(row, row) = diagonal[row];
  R.makeCompressed();
  return R;
}

HeldProblem make_problem(const py::args& arguments, const py::kwargs& options) {
  require_keywords(arguments, options, "Problem(A=, H=, v_free=, mu=) or Problem(W=, u_free=, mu=)",
                   {"A",    "H",        "J",        "M",         "W",
                    "G",    "b",        "v_free",   "u_free",    "mu",
                    "mu_r", "mu_spin",  "dim",      "row_scale", "restitution",
                    "e",    "v_before", "u_before", "name",      "accept_indefinite",
                    "R"});
  const py::object A = option(options, "A", "M"), W = option(options, "W");
  const bool wrenches = !option(options, "H", "J").is_none();
  const py::object v_free = option(options, "v_free"), u_free = option(options, "u_free");
  const py::object mu = option(options, "mu"), row_scale = option(options, "row_scale");
  const bool shocks = !option(options, "restitution", "e").is_none();
  require_a_form(A, wrenches, W, v_free);
  auto made = std::make_shared<PythonProblem>();
  ContactProblem p;
  if (!A.is_none()) {
    take_bodies(p, A, option(options, "H"), option(options, "J"));
    p.v_free = to_vector(v_free, "v_free");
  }
  if (!W.is_none()) p.W = to_rows(W, "W");
  if (mu.is_none()) throw std::invalid_argument("mu is missing");
  if (u_free.is_none() && A.is_none()) throw std::invalid_argument("u_free is missing");
  p.u_free =
      u_free.is_none() ? at_contacts(*made, p, p.v_free, "v_free") : to_vector(u_free, "u_free");
  p.mu = to_numbers(mu, "mu");
  const py::object mu_r = option(options, "mu_r");
  p.dim =
      infer_dim(option(options, "dim"), p.u_free.size(), p.mu, is_one_number(mu), !mu_r.is_none());
  p.mu_r = rolling_coefficient(mu_r, "mu_r", p.mu.size());
  p.mu_spin = rolling_coefficient(option(options, "mu_spin"), "mu_spin", p.mu.size());
  if (!row_scale.is_none()) p.row_scale = to_vector(row_scale, "row_scale");
  require_sound(validate(p));
  const Eigen::Index dofs = p.num_dofs();
  if (const py::object R = option(options, "R"); !R.is_none()) {
    if (!option(options, "G").is_none()) throw std::invalid_argument("R is given with G");
    p = with_compliance(std::move(p), compliance(R));
  }
  if (shocks) {
    if (!row_scale.is_none()) throw std::invalid_argument("row_scale is given with restitution");
    take_restitution(*made, p, options, dofs);
    require_sound(validate(p));
  } else if (has_velocities_before(options)) {
    throw std::invalid_argument("velocities before the impact are given without restitution");
  }
  p = with_joints(std::move(p), options);
  // As for problems from files: with a general A the operator is W itself, assembled once for all.
  if (p.has_velocities() && !p.has_delassus() && p.num_rows() > 0 && !is_diagonal(p.A)) {
    try {
      p.W = assemble_delassus(p.A, p.H, p.dim);
    } catch (const std::runtime_error&) {
      throw std::invalid_argument("A is not positive definite");
    }
  }
  const py::object accept = option(options, "accept_indefinite");
  if (!accept.is_none())
    py::module_::import("bipot._names").attr("flag")(accept, "accept_indefinite");
  // A W that was made here from A and H is one.
  if (!W.is_none()) made->caution = delassus_defect(p);
  if (!made->caution.empty() && (accept.is_none() || !py::bool_(accept))) {
    throw std::invalid_argument(made->caution + "; accept_indefinite=True takes it as it is");
  }
  const py::object name = option(options, "name");
  if (!name.is_none()) made->name = py::str(name).cast<std::string>();
  made->problem = std::make_shared<const ContactProblem>(std::move(p));
  return made;
}

HeldProblem update(const PythonProblem& self, const py::args& arguments,
                   const py::kwargs& options) {
  require_keywords(arguments, options, "update(u_free=, v_free=, mu=, b=)",
                   {"u_free", "v_free", "mu", "b", "v_before", "u_before"});
  const py::object u_free = option(options, "u_free"), v_free = option(options, "v_free");
  const py::object mu = option(options, "mu"), b = option(options, "b");
  const EqualityRows* const rows = self.problem->equality.get();
  if (rows == nullptr && !b.is_none()) throw std::invalid_argument("b is given without G");
  auto made = std::make_shared<PythonProblem>();
  made->name = self.name;
  made->caution = self.caution;
  made->restitution = self.restitution;
  ContactProblem p = without_equality_rows(*self.problem);
  if (!v_free.is_none()) {
    if (!p.has_velocities()) throw std::invalid_argument("v_free is given without A and H");
    p.v_free = to_vector(v_free, "v_free");
  }
  const bool moves = !u_free.is_none() || !v_free.is_none();
  if (moves && made->restitution.size() == 0 && has_velocities_before(options)) {
    if (p.row_scale.size() == 0) {
      throw std::invalid_argument("velocities before the impact are given without restitution");
    }
    made->restitution = p.row_scale.array().square() - 1;  // of a file or a step
  }
  const bool shocks = made->restitution.size() > 0;
  if (!shocks && !v_free.is_none() && p.row_scale.size() > 0 && (p.row_scale.array() != 1).any()) {
    throw std::invalid_argument(
        "restitution needs the velocities before the impact: v_before (n) or u_before (m)");
  }
  if (moves) {
    p.u_free =
        u_free.is_none() ? at_contacts(*made, p, p.v_free, "v_free") : to_vector(u_free, "u_free");
    require_size("u_free", p.u_free.size(), self.problem->num_rows());
    if (shocks) p.u_free = symmetric_velocity(*made, p, options, p.H.rows());
  } else if (has_velocities_before(options)) {
    throw std::invalid_argument("give v_free or u_free with the velocities before the impact");
  }
  if (!mu.is_none()) {
    p.mu = to_numbers(mu, "mu");
    if (is_one_number(mu)) p.mu = Vector::Constant(self.problem->num_contacts(), p.mu[0]);
    require_size("mu", p.mu.size(), self.problem->num_contacts());
    if (shocks) scale_friction(p, 1, p.mu);
  }
  require_sound(validate_vectors(p));
  if (rows != nullptr) {
    p = with_equality_rows(std::move(p), rows->G,
                           b.is_none() ? rows->b : equality_values(b, rows->G), rows->lenient);
  }
  made->problem = std::make_shared<const ContactProblem>(std::move(p));
  return made;
}

/// All of a problem, for pickle.
py::tuple parts_of_problem(const PythonProblem& self) {
  const ContactProblem& p = without_equality_rows(*self.problem);
  const EqualityRows* const rows = self.problem->equality.get();
  const auto part = [](const auto& matrix, bool there) {
    return there ? py::object(parts_of(matrix)) : py::object(py::none());
  };
  py::list guesses;
  for (const Vector& guess : self.guesses) guesses.append(copy_of(guess));
  return py::make_tuple(
      p.dim, part(p.A, p.has_velocities()), part(p.H, p.has_velocities()),
      part(p.W, p.has_delassus()), copy_of(p.v_free), copy_of(p.u_free), copy_of(p.mu),
      copy_of(p.row_scale), copy_of(self.restitution), self.name, copy_of(self.solution), guesses,
      rows != nullptr ? py::object(parts_of(rows->G)) : py::object(py::none()),
      rows != nullptr ? py::object(copy_of(rows->b)) : py::object(py::none()), copy_of(p.mu_r),
      copy_of(p.mu_spin), rows != nullptr && rows->lenient, self.caution);
}

HeldProblem problem_of_parts(const py::tuple& parts) {
  if (parts.size() != 18) throw std::invalid_argument("a Problem that another version pickled");
  auto made = std::make_shared<PythonProblem>();
  ContactProblem p{.dim = parts[0].cast<int>()};
  if (!parts[1].is_none()) p.A = from_parts<SparseMatrix>(parts[1], "A");
  if (!parts[2].is_none()) p.H = from_parts<SparseMatrix>(parts[2], "H");
  if (!parts[3].is_none()) p.W = from_parts<SparseRows>(parts[3], "W");
  p.v_free = to_vector(parts[4], "v_free");
  p.u_free = to_vector(parts[5], "u_free");
  p.mu = to_vector(parts[6], "mu");
  p.row_scale = to_vector(parts[7], "row_scale");
  p.mu_r = to_vector(parts[14], "mu_r");
  p.mu_spin = to_vector(parts[15], "mu_spin");
  require_sound(validate(p));
  made->restitution = to_vector(parts[8], "restitution");
  made->name = parts[9].cast<std::string>();
  made->solution = to_vector(parts[10], "solution");
  for (const py::handle guess : parts[11]) made->guesses.push_back(to_vector(guess, "guesses"));
  made->caution = parts[17].cast<std::string>();
  if (!parts[12].is_none()) {
    p = with_equality_rows(std::move(p), from_parts<SparseRows>(parts[12], "G"),
                           to_vector(parts[13], "b"), parts[16].cast<bool>());
  }
  made->problem = std::make_shared<const ContactProblem>(std::move(p));
  return made;
}

HeldProblem read(const std::filesystem::path& path, bool accept_indefinite) {
  if (!std::filesystem::exists(path)) {
    PyErr_SetString(PyExc_FileNotFoundError, (path.string() + ": no such file").c_str());
    throw py::error_already_set();
  }
  ProblemFile file;
  try {
    const py::gil_scoped_release release;
    file = read_problem(path, accept_indefinite);
  } catch (const FileError& e) {
    throw std::invalid_argument(e.what());  // readable, but not a problem
  }
  auto made = std::make_shared<PythonProblem>(std::move(file.problem), path.stem().string());
  made->caution = std::move(file.caution);
  if (file.r) made->solution = std::move(*file.r);
  made->guesses = std::move(file.guesses);
  return made;
}

void write(const PythonProblem& given, const std::filesystem::path& path, const py::object& s,
           const std::string& title, const std::string& description,
           const std::vector<py::object>& guesses) {
  const ContactProblem& p = *given.problem;
  const auto impulse_of = [&](const py::object& numbers, const char* name) {
    Vector x = to_vector(numbers, name);
    require_size(name, x.size(), p.num_rows());
    if (!x.allFinite()) throw std::invalid_argument(fmt::format("{} is not finite", name));
    return x;
  };
  std::vector<Vector> starts;
  for (const py::object& guess : guesses) starts.push_back(impulse_of(guess, "guesses"));
  const Vector impulse = s.is_none() ? Vector() : impulse_of(s, "s");
  const py::gil_scoped_release release;
  const ProblemInfo info{.title = title, .description = description, .math_info = {}};
  if (impulse.size() == 0) return write_fclib(path, p, info, starts);
  Vector u;
  DelassusOperator(p).velocity(impulse, u);
  AtomicFile file(path);  // with both, or as it was before
  write_fclib(file.draft(), p, info, starts);
  write_fclib_solution(file.draft(), impulse, u);
  file.commit();
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
  require_size("s", x.size(), p.num_rows());
  if (!x.allFinite()) throw std::invalid_argument("s is not finite");
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

/// A property of the equality rows; None without any.
template <class Get>
auto equality_property(Get get) {
  return [get](const HeldProblem& self) -> py::object {
    if (!self->problem->equality) return py::none();
    return get(*self->problem->equality, py::cast(self));
  };
}

/// A view of one of the vectors; None if it is empty and `optional`.
auto vector_property(Vector ContactProblem::*field, bool optional) {
  return [field, optional](const HeldProblem& self) -> py::object {
    const Vector& x = (*self->problem).*field;
    if (optional && x.size() == 0) return py::none();
    return view_of(x, py::cast(self));
  };
}

/// A view of one of the matrices, A and H as they were given; None without it.
template <class Matrix>
auto matrix_property(Matrix ContactProblem::*field, bool (ContactProblem::*has)() const) {
  return [field, has](const HeldProblem& self) -> py::object {
    const bool bodies = has == &ContactProblem::has_velocities;
    const ContactProblem& p = bodies ? without_equality_rows(*self->problem) : *self->problem;
    if (!(p.*has)()) return py::none();
    return scipy_view(p.*field, py::cast(self));
  };
}

void bind_problem_sizes(ProblemClass& problem) {
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
          "num_dofs",
          [](const PythonProblem& self) { return without_equality_rows(*self.problem).num_dofs(); },
          "n, degrees of freedom of the bodies; 0 where the problem has W alone.");
}

void bind_problem_data(ProblemClass& problem) {
  problem
      .def_readonly("name", &PythonProblem::name,
                    "For readers; the stem of the file that it was read from.")
      .def_property_readonly(
          "A", matrix_property(&ContactProblem::A, &ContactProblem::has_velocities),
          "(n, n) mass matrix, csc_matrix of read-only views [kg, kg m²]; None without bodies.")
      .def_property_readonly(
          "H", matrix_property(&ContactProblem::H, &ContactProblem::has_velocities),
          "(n, m) wrench map, csc_matrix of read-only views [-, m]; None without bodies.")
      .def_property_readonly(
          "W", matrix_property(&ContactProblem::W, &ContactProblem::has_delassus),
          "As it was given; None where the problem has bodies alone, see `delassus`.")
      .def_property_readonly(
          "v_free",
          [](const HeldProblem& self) -> py::object {
            const Vector& x = without_equality_rows(*self->problem).v_free;
            return x.size() == 0 ? py::object(py::none()) : view_of(x, py::cast(self));
          },
          "(n,) velocities without contact impulses [m/s, rad/s], a view; None without bodies.")
      .def_property_readonly("u_free", vector_property(&ContactProblem::u_free, false),
                             "(m,) value of u at s = 0 [m/s], under G v = b; read-only view.")
      .def_property_readonly("G", equality_property([](const EqualityRows& rows, py::handle owner) {
                               return scipy_view(rows.G, owner);
                             }),
                             "(p, n) equality rows, csr_matrix of read-only views; None without.")
      .def_property_readonly("b", equality_property([](const EqualityRows& rows, py::handle owner) {
                               return py::object(view_of(rows.b, owner));
                             }),
                             "(p,) G v = b [m/s], read-only view; None without G.")
      .def_property_readonly("mu", vector_property(&ContactProblem::mu, false),
                             "(c,) friction coefficients [-], read-only view.")
      .def_property_readonly("mu_r", vector_property(&ContactProblem::mu_r, true),
                             "(c,) rolling friction [m], read-only view; None without it.")
      .def_property_readonly("mu_spin", vector_property(&ContactProblem::mu_spin, true),
                             "(c,) the same about normals [m], read-only view; None in the plane.")
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
            for (const Vector& x : self->guesses) list.append(view_of(x, py::cast(self)));
            return list;
          },
          "Impulses to start from, of the file or scene, each (m,) [N s].");
}

void bind_problem_methods(ProblemClass& problem) {
  problem
      .def("update", &update,
           R"(The same bodies and contacts with other u_free (m,), v_free (n,), mu, b (p,): a new
problem, in microseconds; with G it is made anew. u_free follows v_free where it is not given. With
restitution all are physical, and v_before or u_before comes with v_free or u_free. Of a file or a
step u_free and mu are the scaled ones, until an update has velocities before the impact. Raises as
the constructor.)")
      .def("__reduce__",
           [](const PythonProblem& self) {
             return py::make_tuple(py::module_::import("bipot._pickle").attr("problem_of"),
                                   py::make_tuple(parts_of_problem(self)));
           })
      .def("__copy__", [](const HeldProblem& self) { return self; })
      .def("__deepcopy__", [](const HeldProblem& self, const py::dict&) { return self; })
      .def("delassus", &delassus,
           "W = H^T A^-1 H (m, m) [1/kg], assembled where the problem does not have it.")
      .def("velocity", &velocities, py::arg("s"), "u = W s + u_free (m,) [m/s].")
      .def(
          "body_velocity", &bodies, py::arg("s"),
          "v = v_free + A^-1 (H s + G^T multipliers) (n,) [m/s, rad/s]. Raises ValueError without bodies.")
      .def("__repr__", [](const PythonProblem& self) {
        const ContactProblem& p = *self.problem;
        return fmt::format(
            "<bipot.Problem{}: {}, d = {}{}>", self.name.empty() ? "" : " " + self.name,
            counted(p.num_contacts(), "contact"), p.dim,
            p.has_velocities()
                ? fmt::format(", {} degrees of freedom", without_equality_rows(p).num_dofs())
                : ", given by W");
      });
}

}  // namespace

void bind_problem(py::module_& module) {
  ProblemClass problem(module, "Problem", py::is_final(),
                       R"(One frictional contact problem, checked and immutable.

Either bodies, A (n, n) symmetric positive definite [kg, kg m²], H (n, m) and v_free (n,)
[m/s, rad/s], or W (m, m) [1/kg], or both; u_free (m,) [m/s], H^T v_free where it is left out with
bodies; mu (c,), or one number with `dim`. M is another name of A; J (m, n), the Jacobian H^T, may
stand for H. Matrices are anything of scipy.sparse, or dense arrays; duplicates are summed, explicit
zeros dropped; integers and float32 become float64. Everything is copied. dim (1, 2 or 3 rows a
contact) is len(u_free) / len(mu) where it is not given.

G (p, n) [-, m] and b (p,) [m/s], 0 where it is left out: equality rows G v = b, bilateral joints
between the bodies. `Result.v` obeys them, `Result.multipliers` are their impulses. `u_free` and
`delassus()` of the problem are those under the rows; A, H and v_free are as given.

R (m,), a diagonal, or (m, m), symmetric blocks of contacts, at least 0 [1/kg], makes contacts
compliant: u = (W + R) s + u_free. With bodies, degrees of freedom of mass 1 are appended to A, H,
v_free and `Result.v`, one for each non-zero eigenvalue of R; not with G.

mu_r, one number or (c,) [m], is rolling friction: contacts then have 3 rows in the plane (normal,
tangent, moment), and in space 6 (two tangents, two moments about them, one about the normal), with
mu_spin [m] for the last.

restitution or e: e_n for all contacts, (c,) for each, or (m,) for each row, from 0 to 1, with the
velocities before the impact, v_before (n,) or u_before (m,) = H^T v_before; all else as without it.
u of the solution is then r (u_after + e u_before) / (1 + e) and s is r times the impulse, with
r = sqrt(1 + e) = `row_scale`: `Result.impulse` and `Result.v` are physical. H, W, u_free and mu of
the problem are scaled likewise (data/manual/explanation/method.md, section 3); row_scale (m,) is for
problems that are given in these variables.

Raises ValueError with the field and both sizes, or the entry and its value; TypeError for what is
no array of real numbers or an option that does not exist.

All arrays and matrices that it returns are read-only views into the problem, without copies,
but for `delassus()` where W must be assembled, `velocity` and `body_velocity`.)");
  // Made by __new__, not by __init__: no Problem exists without its data, and none changes.
  problem.attr("__new__") =
      py::cpp_function([](const py::handle&, const py::args& arguments, const py::kwargs& options) {
        return make_problem(arguments, options);
      });
  problem.attr("__init__") = py::cpp_function(
      [](const py::object&, const py::args&, const py::kwargs&) {}, py::is_method(problem));
  bind_problem_sizes(problem);
  bind_problem_data(problem);
  bind_problem_methods(problem);
  module.def("_problem_of_parts", &problem_of_parts, py::arg("parts"));
  module.def("read", &read, py::arg("path"), py::arg("accept_indefinite"));
  module.def("write", &write, py::arg("problem"), py::arg("path"), py::arg("s"), py::arg("title"),
             py::arg("description"), py::arg("guesses"));
}

}  // namespace bipot
