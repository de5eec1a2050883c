#include <pybind11/stl/filesystem.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <type_traits>
#include <variant>
#include <vector>

#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "core/motion/population.h"
#include "core/run_files/run_layout.h"
#include "core/run_files/run_reader.h"

namespace bipot {

namespace py = pybind11;

template <int D>
std::string motion_name(typename Wall<D>::Motion motion) {
  constexpr const char* kNames[] = {"fixed", "moving", "driven"};
  return kNames[static_cast<int>(motion)];
}

namespace {

/// A candidate contact of a step, as a row of numpy.
struct ContactRow {
  std::int64_t i, j;
  double n_x, n_y, gap, s_n, s_t, u_n, u_t;
  std::int64_t status;
};
struct SphereContactRow {
  std::int64_t i, j;
  double n_x, n_y, n_z, gap, s_n, s_tx, s_ty, s_tz, u_n, u_tx, u_ty, u_tz;
  std::int64_t status;
};

ContactRow row_of(const ContactOutcome<2>& c) {
  return {c.contact.i,     c.contact.j,
          c.contact.n.x(), c.contact.n.y(),
          c.contact.gap,   c.s_n,
          c.s_t,           c.u_n,
          c.u_t,           static_cast<std::int64_t>(c.status)};
}
SphereContactRow row_of(const ContactOutcome<3>& c) {
  const Vec3& n = c.contact.n;
  return {c.contact.i,   c.contact.j, n.x(),     n.y(),     n.z(),
          c.contact.gap, c.s_n,       c.s_t.x(), c.s_t.y(), c.s_t.z(),
          c.u_n,         c.u_t.x(),   c.u_t.y(), c.u_t.z(), static_cast<std::int64_t>(c.status)};
}

/// As history_type() in solve_binding.cc.
template <class Row>
py::dtype contact_type() {
  static const bool told = [] {
    if constexpr (std::is_same_v<Row, ContactRow>) {
      PYBIND11_NUMPY_DTYPE(ContactRow, i, j, n_x, n_y, gap, s_n, s_t, u_n, u_t, status);
    } else {
      PYBIND11_NUMPY_DTYPE(SphereContactRow, i, j, n_x, n_y, n_z, gap, s_n, s_tx, s_ty, s_tz, u_n,
                           u_tx, u_ty, u_tz, status);
    }
    return true;
  }();
  static_cast<void>(told);
  return py::dtype::of<Row>();
}

template <int D>
py::array contacts_of(const State<D>& state) {
  using Row = std::conditional_t<D == 2, ContactRow, SphereContactRow>;
  std::vector<Row> rows;
  rows.reserve(state.contacts.size());
  for (const ContactOutcome<D>& c : state.contacts) rows.push_back(row_of(c));
  return py::array(contact_type<Row>(), {static_cast<py::ssize_t>(rows.size())}, rows.data());
}

template <int D>
std::string shape_name(typename Wall<D>::Shape shape) {
  constexpr const char* kPlane[] = {"half-plane",   "segment",   "hollow circle",
                                    "solid circle", "triangles", "cone"};
  constexpr const char* kSpace[] = {"half-space",     "segment",   "hollow cylinder",
                                    "solid cylinder", "triangles", "cone"};
  return (D == 2 ? kPlane : kSpace)[static_cast<int>(shape)];
}

}  // namespace

template <int D>
py::list walls_of(const State<D>& state) {
  const auto numbers = [](const Vec<D>& x) {
    py::tuple tuple(D);
    for (int k = 0; k < D; ++k) tuple[to_size(k)] = x[k];
    return tuple;
  };
  py::list walls;
  for (const Wall<D>& wall : state.walls) {
    using Shape = typename Wall<D>::Shape;
    const bool segment = wall.shape == Shape::kSegment || wall.shape == Shape::kCone;
    const bool directed = wall.shape == Shape::kHalfPlane || (D == 3 && wall.is_circle());
    py::dict row;
    row["name"] = wall.name;
    row["shape"] = shape_name<D>(wall.shape);
    row["motion"] = motion_name<D>(wall.motion);
    row["a"] = numbers(wall.a);
    row["b"] = segment ? py::object(numbers(wall.b)) : py::object(py::none());
    row["normal"] = directed ? py::object(numbers(wall.normal)) : py::object(py::none());
    row["radius"] = wall.is_circle() ? py::object(py::float_(wall.radius)) : py::object(py::none());
    row["velocity"] = numbers(wall.v);
    row["force"] = wall.force;
    walls.append(row);
  }
  return walls;
}

template py::list walls_of<2>(const State<2>&);
template py::list walls_of<3>(const State<3>&);
template std::string motion_name<2>(Wall<2>::Motion);
template std::string motion_name<3>(Wall<3>::Motion);

namespace {

template <int D>
using StateClass = py::class_<PythonState<D>, std::shared_ptr<PythonState<D>>>;

/// Arrays over the disks or spheres of a state.
template <int D>
void bind_bodies(StateClass<D>& bound) {
  const auto scalars = [](double Body<D>::*field) {
    return [field](const py::object& self) {
      const std::vector<Body<D>>& bodies = self.cast<const PythonState<D>&>().state.bodies;
      const double* first = bodies.empty() ? nullptr : &(bodies.front().*field);
      return view_of(first, static_cast<Eigen::Index>(bodies.size()), self, sizeof(Body<D>));
    };
  };
  const auto vectors = [](Vec<D> Body<D>::*field) {
    return [field](const py::object& self) {
      const std::vector<Body<D>>& bodies = self.cast<const PythonState<D>&>().state.bodies;
      const double* first = bodies.empty() ? nullptr : (bodies.front().*field).data();
      return view_of_rows(first, static_cast<Eigen::Index>(bodies.size()), D, sizeof(Body<D>),
                          self);
    };
  };
  bound.def_property_readonly("positions", vectors(&Body<D>::x), "(n, 2), in 3D (n, 3) [m]")
      .def_property_readonly("velocities", vectors(&Body<D>::v), "(n, 2), in 3D (n, 3) [m/s]")
      .def_property_readonly("radii", scalars(&Body<D>::radius), "(n,) [m]")
      .def_property_readonly("masses", scalars(&Body<D>::mass), "(n,) [kg]")
      .def_property_readonly(
          "numbers",
          [](const PythonState<D>& self) {
            const int n = static_cast<int>(self.state.bodies.size());
            py::array_t<std::int64_t> numbers(n);
            auto to = numbers.template mutable_unchecked<1>();
            for (int k = 0; k < n; ++k) to(k) = body_number(self.state, k);
            numbers.attr("setflags")(py::arg("write") = false);
            return numbers;
          },
          "(n,), numbers that bodies keep while others come and go; a copy.");
  if constexpr (D == 2) {
    bound.def_property_readonly("angles", scalars(&Disk::angle), "(n,) [rad]")
        .def_property_readonly("spins", scalars(&Disk::spin), "(n,) [rad/s]");
  } else {
    bound.def_property_readonly("spins", vectors(&Sphere::spin), "(n, 3) [rad/s]")
        .def_property_readonly(
            "orientations",
            [](const PythonState<D>& self) {
              const std::vector<Sphere>& spheres = self.state.bodies;
              py::array_t<double> rows({static_cast<py::ssize_t>(spheres.size()), py::ssize_t{4}});
              auto to = rows.template mutable_unchecked<2>();
              for (std::size_t k = 0; k < spheres.size(); ++k) {
                const Eigen::Quaterniond& q = spheres[k].orientation;
                const double parts[] = {q.w(), q.x(), q.y(), q.z()};
                for (int c = 0; c < 4; ++c) to(static_cast<py::ssize_t>(k), c) = parts[c];
              }
              rows.attr("setflags")(py::arg("write") = false);
              return rows;
            },
            "(n, 4), unit quaternions (w, x, y, z); a copy.");
  }
}

/// What a step's candidate contacts are in Python.
template <int D>
constexpr const char* kContactsText =
    D == 2
        ? R"(Structured array of the last step's candidates, a copy: i, j (disk j, or wall j - n), n_x,
n_y (from j to i), gap [m], s_n, s_t (on disk i) [N s], u_n, u_t [m/s], status (0 open, 1
stick, 2 slip).)"
        : R"(Structured array of the last step's candidates, a copy: i, j (sphere j, or wall j - n), n_x,
n_y, n_z (from j to i), gap [m], s_n, s_tx, s_ty, s_tz (on sphere i) [N s], u_n, u_tx, u_ty, u_tz
[m/s], status (0 open, 1 stick, 2 slip).)";
constexpr const char* kWallsText =
    "name, shape, motion, a, b [m], normal (of cylinders the axis), radius [m], velocity [m/s], "
    "force [N] of each; copies.";

template <int D>
void bind_state_in(py::module_& module) {
  StateClass<D> state(module, D == 2 ? "State" : "SphereState",
                      "A copy of where everything is; arrays are read-only views into it.");
  refuse_new(state);
  bind_bodies(state);
  state
      .def_property_readonly(
          "step", [](const PythonState<D>& s) { return s.state.step; }, "Steps done.")
      .def_property_readonly(
          "time", [](const PythonState<D>& s) { return s.state.time; }, "[s]")
      .def_property_readonly(
          "contacts", [](const PythonState<D>& s) { return contacts_of<D>(s.state); },
          kContactsText<D>)
      .def_property_readonly(
          "walls", [](const PythonState<D>& s) { return walls_of<D>(s.state); }, kWallsText);
}

py::object read_run_state(const std::filesystem::path& run, int step) {
  return std::visit(
      []<int D>(State<D>&& state) {
        return py::cast(std::make_shared<PythonState<D>>(PythonState<D>{std::move(state)}));
      },
      read_any_state(run, step));
}

}  // namespace

void bind_state(py::module_& module) {
  bind_state_in<2>(module);
  bind_state_in<3>(module);
  module.def("read_run_state", &read_run_state, py::arg("run"), py::arg("step"));
  module.def(
      "run_steps",
      [](const std::filesystem::path& run) { return steps_in_folder(run_folder(run)); },
      py::arg("run"));
}

}  // namespace bipot
