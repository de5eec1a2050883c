#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "bench/problems/scene_catalogue.h"
#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "bench/python/callable_solver.h"
#include "bench/python/python_problem.h"
#include "bench/python/python_watch.h"
#include "core/base/counted.h"
#include "core/base/nearest_name.h"
#include "core/run_files/run_output.h"
#include "core/run_files/run_reader.h"
#include "core/scene_files/scene_file.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_start.h"
#include "solvers/simulation/scene_stepper.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

namespace py = pybind11;

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
std::string name_of(typename Wall<D>::Motion motion) {
  using Motion = typename Wall<D>::Motion;
  switch (motion) {
    case Motion::kFixed:
      return "fixed";
    case Motion::kMoving:
      return "moving";
    case Motion::kDriven:
      return "driven";
  }
  return "";
}

template <int D>
std::string name_of(typename Wall<D>::Shape shape) {
  using Shape = typename Wall<D>::Shape;
  switch (shape) {
    case Shape::kHalfPlane:
      return D == 2 ? "half-plane" : "half-space";
    case Shape::kSegment:
      return "segment";
    case Shape::kHollowCircle:
      return D == 2 ? "hollow circle" : "hollow cylinder";
    case Shape::kSolidCircle:
      return D == 2 ? "solid circle" : "solid cylinder";
    case Shape::kMesh:
      return "triangles";
    case Shape::kCone:
      return "cone";
  }
  return "";
}

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
    row["shape"] = name_of<D>(wall.shape);
    row["motion"] = name_of<D>(wall.motion);
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

/// A constant snapshot of the state between two steps.
template <int D>
struct PythonState {
  State<D> state;
};

/// The report of one step, likewise.
template <int D>
struct PythonStep {
  State<D> state;
  StepReport<D> report;
  std::shared_ptr<PythonProblem> problem;
};
template <int D>
using Step = std::shared_ptr<PythonStep<D>>;

/// Options of Python for a run; unset entries are the scene's.
struct SimulationChoice {
  py::object solver;  ///< None, a name or a callable
  std::optional<double> tol;
  std::optional<int> max_iterations;
  std::optional<bool> warm_start;
  std::map<std::string, std::string> parameters;
  std::optional<double> step, friction;
  std::optional<int> num_steps;
};

/// A scene that Python runs step by step.
template <int D>
class PythonSimulation {
 public:
  /// `text`: of the scene, for its copies.
  PythonSimulation(Scene<D> scene, std::string text, const SimulationChoice& choice)
      : scene_(std::move(scene)), text_(std::move(text)) {
    choose(choice);
    check_start(scene_, {}, 1);
    state_ = initial_state(scene_);
  }
  PythonSimulation(const PythonSimulation&) = delete;  // the stepper looks at the scene
  PythonSimulation& operator=(const PythonSimulation&) = delete;

  const Scene<D>& scene() const { return scene_; }
  const std::string& text() const { return text_; }
  const State<D>& state() const {
    require_rest();
    return state_;
  }

  /// Writes the state into an empty folder, bit for bit, as a run does. Throws FileError.
  void save(const std::filesystem::path& folder) const {
    require_rest();
    Scene<D> now = scene_;  // Python may have set forces
    for (std::size_t k = 0; k < now.walls.size(); ++k) now.walls[k].force = state_.walls[k].force;
    RunWriter<D> writer(folder, now, text_);
    writer.frame(state_);
    writer.close();
  }
  void load(const std::filesystem::path& folder) {
    require_rest();
    state_ = read_state<D>(folder);
  }

  Step<D> advance() {
    require_rest();
    const Stepping stepping(stepping_);
    watch_ = PythonWatch();
    auto step = std::make_shared<PythonStep<D>>();
    std::optional<StepFailure> failure;
    {
      const py::gil_scoped_release release;
      try {
        step->report = stepper_->advance(state_);
        step->state = state_;
      } catch (const StepFailure& e) {
        failure = e;
      }
    }
    watch_.rethrow();
    if (failure && failure->kind == StepFailure::Kind::kInvalidInput) {
      throw std::invalid_argument(failure->what());
    }
    if (failure) throw *failure;
    step->problem = std::make_shared<PythonProblem>(stepper_->problem(),
                                                    fmt::format("step_{}", step->report.step));
    if (stepper_->start().size() > 0) step->problem->guesses.push_back(stepper_->start());
    return step;
  }

  /// The wall of that name or number. Throws std::invalid_argument.
  Wall<D>& wall(const py::object& which) {
    require_rest();
    if (py::isinstance<py::int_>(which)) {
      const auto k = which.cast<std::int64_t>();
      if (k >= 0 && k < static_cast<std::int64_t>(state_.walls.size())) {
        return state_.walls[to_size(k)];
      }
      throw std::invalid_argument(fmt::format("wall {}: the scene has walls 0 to {}", k,
                                              static_cast<std::int64_t>(state_.walls.size()) - 1));
    }
    return find_named("wall", which.cast<std::string>(), state_.walls);
  }

 private:
  /// Marks a step in progress.
  struct Stepping {
    explicit Stepping(bool& flag) : flag_(flag) { flag_ = true; }
    ~Stepping() { flag_ = false; }
    Stepping(const Stepping&) = delete;
    Stepping& operator=(const Stepping&) = delete;
    bool& flag_;
  };

  /// Another thread, or a solver in Python, may call during a step.
  void require_rest() const {
    if (stepping_) throw std::runtime_error("the simulation is in the middle of a step");
  }

  void choose(const SimulationChoice& choice) {
    if (choice.step) scene_.step = *choice.step;
    if (choice.num_steps) scene_.num_steps = *choice.num_steps;
    if (choice.friction) {
      for (ContactLaw& law : scene_.laws) law.mu = *choice.friction;
    }
    if (std::string defect = validate(scene_); !defect.empty()) {
      throw std::invalid_argument(defect);
    }
    SolverChoice& own = scene_.solver;
    const bool callable = !choice.solver.is_none() && !py::isinstance<py::str>(choice.solver);
    if (callable) {
      chosen_ = choose_solver(choice.solver, watch_);
      own.parameters.clear();
    } else if (!choice.solver.is_none()) {
      const auto name = choice.solver.cast<std::string>();
      if (name != own.name) own.parameters.clear();
      own.name = name;
    }
    if (choice.tol) own.tol = *choice.tol;
    if (choice.max_iterations) own.max_iterations = *choice.max_iterations;
    if (choice.warm_start) own.warm_start = *choice.warm_start;
    for (const auto& [name, value] : choice.parameters) own.parameters[name] = value;
    const auto cancelled = [this] { return watch_.stopped(); };
    const bool rigid = scene_.model == Model::kNonsmooth || !choice.solver.is_none();
    if (!rigid) {
      stepper_.emplace(scene_, SceneRunOptions<D>{.cancelled = cancelled});
      return;
    }
    if (!callable) chosen_.entry = require_solver(own.name);
    SolverOptions options = to_options(own);
    options.cancelled = cancelled;
    stepper_.emplace(
        scene_, SceneRunOptions<D>{.solver = make_step_solver(chosen_.entry, std::move(options)),
                                   .explicit_delassus = chosen_.entry.needs_delassus});
  }

  Scene<D> scene_;
  std::string text_;
  State<D> state_;
  bool stepping_ = false;  // read and written with Python's lock held
  PythonWatch watch_;
  ChosenSolver chosen_;
  std::optional<SceneStepper<D>> stepper_;
};

template <int D>
void set_wall(PythonSimulation<D>& self, const py::object& which, const py::object& velocity,
              const py::object& force) {
  Wall<D>& wall = self.wall(which);
  using Motion = typename Wall<D>::Motion;
  const auto require = [&](Motion motion, const char* what, const char* key) {
    if (wall.motion == motion) return;
    throw std::invalid_argument(
        fmt::format("wall '{}' is {}: a wall with a {} needs '{}' in the scene", wall.name,
                    name_of<D>(wall.motion), what, key));
  };
  if (!velocity.is_none()) {
    require(Motion::kMoving, "velocity", "velocity");
    const Vector v = to_vector(velocity, "velocity");
    if (v.size() != D || !v.allFinite()) {
      throw std::invalid_argument(
          fmt::format("velocity has size {}, expected {} finite numbers", v.size(), D));
    }
    wall.v = v;
  }
  if (!force.is_none()) {
    require(Motion::kDriven, "force", "force");
    const double f = to_number(force, "force");
    if (!std::isfinite(f)) throw std::invalid_argument(fmt::format("force = {} is not finite", f));
    wall.force = f;
  }
}

/// Arrays over the disks or spheres of a state.
template <int D, class Class>
void bind_bodies(Class& bound) {
  const auto scalars = [](double Body<D>::*field) {
    return [field](const typename Class::holder_type& self) {
      const std::vector<Body<D>>& bodies = self->state.bodies;
      const double* first = bodies.empty() ? nullptr : &(bodies.front().*field);
      return view_of(first, static_cast<Eigen::Index>(bodies.size()), py::cast(self),
                     sizeof(Body<D>));
    };
  };
  const auto vectors = [](Vec<D> Body<D>::*field) {
    return [field](const typename Class::holder_type& self) {
      const std::vector<Body<D>>& bodies = self->state.bodies;
      const double* first = bodies.empty() ? nullptr : (bodies.front().*field).data();
      return view_of_rows(first, static_cast<Eigen::Index>(bodies.size()), D, sizeof(Body<D>),
                          py::cast(self));
    };
  };
  bound.def_property_readonly("positions", vectors(&Body<D>::x), "(n, 2), in 3D (n, 3) [m]")
      .def_property_readonly("velocities", vectors(&Body<D>::v), "(n, 2), in 3D (n, 3) [m/s]")
      .def_property_readonly("radii", scalars(&Body<D>::radius), "(n,) [m]")
      .def_property_readonly("masses", scalars(&Body<D>::mass), "(n,) [kg]");
  if constexpr (D == 2) {
    bound.def_property_readonly("angles", scalars(&Disk::angle), "(n,) [rad]")
        .def_property_readonly("spins", scalars(&Disk::spin), "(n,) [rad/s]");
  } else {
    bound.def_property_readonly("spins", vectors(&Sphere::spin), "(n, 3) [rad/s]")
        .def_property_readonly(
            "orientations",
            [](const typename Class::holder_type& self) {
              const std::vector<Sphere>& spheres = self->state.bodies;
              py::array_t<double> rows({static_cast<py::ssize_t>(spheres.size()), py::ssize_t{4}});
              auto to = rows.template mutable_unchecked<2>();
              for (std::size_t k = 0; k < spheres.size(); ++k) {
                const Eigen::Quaterniond& q = spheres[k].orientation;
                const double parts[] = {q.w(), q.x(), q.y(), q.z()};
                for (int c = 0; c < 4; ++c) to(static_cast<py::ssize_t>(k), c) = parts[c];
              }
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
void bind_state(py::module_& module) {
  py::class_<PythonState<D>, std::shared_ptr<PythonState<D>>> state(
      module, D == 2 ? "State" : "SphereState",
      "A copy of where everything is; arrays are read-only views into it.");
  refuse_new(state);
  bind_bodies<D>(state);
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

template <int D>
void bind_step(py::module_& module) {
  using PythonStep = PythonStep<D>;
  py::class_<PythonStep, Step<D>> step(module, D == 2 ? "Step" : "SphereStep",
                                       "One step that was taken.");
  refuse_new(step);
  bind_bodies<D>(step);
  const auto of_report = [](auto StepReport<D>::*field) {
    return [field](const PythonStep& s) { return s.report.*field; };
  };
  const auto of_error = [](auto ContactError::*field) {
    return [field](const PythonStep& s) { return s.report.error.*field; };
  };
  step.def_property_readonly("step", of_report(&StepReport<D>::step), "Number of the step.")
      .def_property_readonly("time", of_report(&StepReport<D>::time), "At its end [s].")
      .def_property_readonly("converged", of_report(&StepReport<D>::converged),
                             "Whether the solve met its tolerance.")
      .def_property_readonly("message", of_report(&StepReport<D>::message),
                             "How the solve ended, in words.")
      .def_property_readonly("iterations", of_report(&StepReport<D>::iterations), "Of the solver.")
      .def_property_readonly("penetration", of_report(&StepReport<D>::penetration),
                             "Largest overlap at mid-step [m].")
      .def_property_readonly(
          "parts", [](const PythonStep& s) { return s.report.cut.parts; },
          "Into which an accuracy cut it; 0: none was asked for.")
      .def_property_readonly("solve_seconds", of_report(&StepReport<D>::solve_seconds),
                             "Wall time of the solve [s].")
      .def_property_readonly("epsilon", of_error(&ContactError::epsilon),
                             "Guarded form of the paper's (42).")
      .def_property_readonly("eta", of_error(&ContactError::eta), "Natural map in energy.")
      .def_property_readonly("raw42", of_error(&ContactError::raw42),
                             "The paper's (42); nan where nothing slides.")
      .def_property_readonly(
          "guarded", [](const PythonStep& s) { return s.report.error.guarded(); },
          "max(epsilon, eta).")
      .def_readonly(
          "problem", &PythonStep::problem,
          R"(The contact problem that it solved; its guess is the impulse that the solver started
from.)")
      .def_property_readonly(
          "contacts", [](const PythonStep& s) { return contacts_of<D>(s.state); }, kContactsText<D>)
      .def_property_readonly(
          "walls", [](const PythonStep& s) { return walls_of<D>(s.state); }, kWallsText)
      .def_property_readonly(
          "energy",
          [](const PythonStep& s) {
            const EnergyLedger& e = s.report.energy;
            py::dict out;
            out["kinetic"] = e.kinetic;
            out["potential"] = e.potential;
            out["wall_work"] = e.wall_work;
            out["friction_loss"] = e.friction_loss;
            out["shock_loss"] = e.shock_loss;
            out["imbalance"] = e.imbalance;
            out["elastic"] = e.elastic;
            out["cohesion_loss"] = e.cohesion_loss;
            return out;
          },
          "kinetic, potential, wall_work, friction_loss, shock_loss, imbalance, elastic, cohesion_loss [J].")
      .def("__repr__", [](const PythonStep& s) {
        return fmt::format("<bipot.{} {} at t = {:g} s: {}, {}>", D == 2 ? "Step" : "SphereStep",
                           s.report.step, s.report.time, counted(s.report.contacts, "contact"),
                           s.report.converged ? "converged" : s.report.message);
      });
}

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A simulation of disks or of spheres, as the scene has them. `scene`: file or shipped scene, or
/// the name in messages of the text.
py::object make_simulation(const std::string& scene, const std::optional<std::string>& given,
                           const py::object& solver, std::optional<double> tol,
                           std::optional<int> max_iterations, std::optional<bool> warm_start,
                           std::map<std::string, std::string> parameters,
                           std::optional<double> step, std::optional<int> num_steps,
                           std::optional<double> friction, std::optional<double> accuracy) {
  const SimulationChoice choice{.solver = solver,
                                .tol = tol,
                                .max_iterations = max_iterations,
                                .warm_start = warm_start,
                                .parameters = std::move(parameters),
                                .step = step,
                                .friction = friction,
                                .num_steps = num_steps};
  const std::string source = given ? scene : find_scene(scene).string();
  std::string text = given ? *given : content_of(source);
  AnyScene read = parse_any_scene(text, source, accuracy);
  return std::visit(
      [&]<int D>(Scene<D>& one) {
        return py::cast(
            std::make_unique<PythonSimulation<D>>(std::move(one), std::move(text), choice));
      },
      read);
}

template <int D>
void bind_simulation_in(py::module_& module) {
  using Simulation = PythonSimulation<D>;
  bind_state<D>(module);
  bind_step<D>(module);
  py::class_<Simulation> simulation(module, D == 2 ? "Simulation" : "SphereSimulation");
  refuse_new(simulation);
  simulation.def("advance", &Simulation::advance)
      .def_property_readonly("state",
                             [](const Simulation& s) {
                               return std::make_shared<PythonState<D>>(PythonState<D>{s.state()});
                             })
      .def("set_wall", &set_wall<D>, py::arg("wall"), py::arg("velocity"), py::arg("force"))
      .def("save", &Simulation::save, py::arg("folder"))
      .def("load", &Simulation::load, py::arg("folder"))
      .def_property_readonly("text", &Simulation::text)
      .def_property_readonly("source", [](const Simulation& s) { return s.scene().source; })
      .def_property_readonly("title", [](const Simulation& s) { return s.scene().title; })
      .def_property_readonly("time", [](const Simulation& s) { return s.state().time; })
      .def_property_readonly("steps_done", [](const Simulation& s) { return s.state().step; })
      .def_property_readonly("num_steps", [](const Simulation& s) { return s.scene().num_steps; })
      .def_property_readonly("step_size", [](const Simulation& s) { return s.scene().step; })
      .def_property_readonly("walls", [](const Simulation& s) { return walls_of<D>(s.state()); });
}

}  // namespace

void bind_simulation(py::module_& module) {
  py::register_exception<StepFailure>(module, "StepError", PyExc_RuntimeError);
  bind_simulation_in<2>(module);
  bind_simulation_in<3>(module);
  module.def("make_simulation", &make_simulation, py::arg("scene"), py::arg("text"),
             py::arg("solver"), py::arg("tol"), py::arg("max_iterations"), py::arg("warm_start"),
             py::arg("parameters"), py::arg("step"), py::arg("num_steps"), py::arg("friction"),
             py::arg("accuracy"));
}

}  // namespace bipot
