#include <fmt/format.h>
#include <pybind11/stl.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "bench/python/callable_solver.h"
#include "bench/python/python_problem.h"
#include "bench/python/python_watch.h"
#include "bench/scenes/scene_catalogue.h"
#include "bench/scenes/scene_stepper.h"
#include "core/files/scene_file.h"
#include "core/nearest_name.h"
#include "solvers/registry.h"
#include "solvers/step_solver.h"

namespace bipot {
namespace {

namespace py = pybind11;

/// A candidate contact of a step, as numpy has it.
struct ContactRow {
  std::int64_t i, j;
  double n_x, n_y, gap, s_n, s_t, u_n, u_t;
  std::int64_t status;
};

/// As history_type() in solve_binding.cc.
py::dtype contact_type() {
  static const bool told = [] {
    PYBIND11_NUMPY_DTYPE(ContactRow, i, j, n_x, n_y, gap, s_n, s_t, u_n, u_t, status);
    return true;
  }();
  static_cast<void>(told);
  return py::dtype::of<ContactRow>();
}

py::array contacts_of(const State& state) {
  std::vector<ContactRow> rows;
  rows.reserve(state.contacts.size());
  for (const ContactOutcome& c : state.contacts) {
    rows.push_back({c.contact.i, c.contact.j, c.contact.n.x(), c.contact.n.y(), c.contact.gap,
                    c.s_n, c.s_t, c.u_n, c.u_t, static_cast<std::int64_t>(c.status)});
  }
  return py::array(contact_type(), {static_cast<py::ssize_t>(rows.size())}, rows.data());
}

std::string name_of(Wall::Motion motion) {
  switch (motion) {
    case Wall::Motion::kFixed:
      return "fixed";
    case Wall::Motion::kMoving:
      return "moving";
    case Wall::Motion::kDriven:
      return "driven";
  }
  return "";
}

py::list walls_of(const State& state) {
  const auto pair = [](const Vec2& x) { return py::make_tuple(x.x(), x.y()); };
  py::list walls;
  for (const Wall& wall : state.walls) {
    const bool segment = wall.shape == Wall::Shape::kSegment;
    py::dict row;
    row["name"] = wall.name;
    row["shape"] = segment ? "segment" : "half-plane";
    row["motion"] = name_of(wall.motion);
    row["a"] = pair(wall.a);
    row["b"] = segment ? py::object(pair(wall.b)) : py::object(py::none());
    row["normal"] = segment ? py::object(py::none()) : py::object(pair(wall.normal));
    row["velocity"] = pair(wall.v);
    row["force"] = wall.force;
    walls.append(row);
  }
  return walls;
}

/// Where everything is between two steps: a snapshot that nothing changes any more.
struct PythonState {
  State state;
};

/// One step that was taken, likewise.
struct PythonStep {
  State state;
  StepReport report;
  std::shared_ptr<PythonProblem> problem;
};
using Step = std::shared_ptr<PythonStep>;

/// What Python may say of how a scene is run; unset entries are the scene's.
struct SimulationChoice {
  py::object solver;  ///< None, a name or a callable
  std::optional<double> tol;
  std::optional<int> max_iterations;
  std::optional<bool> warm_start;
  std::map<std::string, std::string> parameters;
  std::optional<double> step, friction;
  std::optional<int> num_steps;
};

/// A scene that Python takes step by step.
class PythonSimulation {
 public:
  PythonSimulation(const std::string& scene, const SimulationChoice& choice)
      : scene_(read_scene(find_scene(scene))) {
    choose(choice);
    state_ = initial_state(scene_);
  }
  PythonSimulation(const PythonSimulation&) = delete;  // the stepper looks at the scene
  PythonSimulation& operator=(const PythonSimulation&) = delete;

  const Scene& scene() const { return scene_; }
  const State& state() const {
    require_rest();
    return state_;
  }

  Step advance() {
    require_rest();
    const Stepping stepping(stepping_);
    watch_ = PythonWatch();
    auto step = std::make_shared<PythonStep>();
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
  Wall& wall(const py::object& which) {
    require_rest();
    if (py::isinstance<py::int_>(which)) {
      const auto k = which.cast<std::int64_t>();
      if (k >= 0 && k < static_cast<std::int64_t>(state_.walls.size())) {
        return state_.walls[to_size(k)];
      }
      throw std::invalid_argument(fmt::format("wall {}: the scene has walls 0 to {}", k,
                                              static_cast<std::int64_t>(state_.walls.size()) - 1));
    }
    const auto name = which.cast<std::string>();
    std::vector<std::string> names;
    for (Wall& wall : state_.walls) {
      if (wall.name == name) return wall;
      names.push_back(wall.name);
    }
    throw std::invalid_argument(unknown_name_message("wall", name, names));
  }

 private:
  /// Marks a step that is being taken.
  struct Stepping {
    explicit Stepping(bool& flag) : flag_(flag) { flag_ = true; }
    ~Stepping() { flag_ = false; }
    Stepping(const Stepping&) = delete;
    Stepping& operator=(const Stepping&) = delete;
    bool& flag_;
  };

  /// Another thread, or a solver in Python, may come while a step is taken.
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
      stepper_.emplace(scene_, StepSolver(), false, cancelled);
      return;
    }
    if (!callable) chosen_.entry = require_solver(own.name);
    SolverOptions options = to_options(own);
    options.cancelled = cancelled;
    stepper_.emplace(scene_, make_step_solver(chosen_.entry, std::move(options)),
                     chosen_.entry.needs_delassus);
  }

  Scene scene_;
  State state_;
  bool stepping_ = false;  // read and written with Python's lock held
  PythonWatch watch_;
  ChosenSolver chosen_;
  std::optional<SceneStepper> stepper_;
};

void set_wall(PythonSimulation& self, const py::object& which, const py::object& velocity,
              const py::object& force) {
  Wall& wall = self.wall(which);
  const auto require = [&](Wall::Motion motion, const char* what, const char* key) {
    if (wall.motion == motion) return;
    throw std::invalid_argument(
        fmt::format("wall '{}' is {}: a wall with a {} needs '{}' in the scene", wall.name,
                    name_of(wall.motion), what, key));
  };
  if (!velocity.is_none()) {
    require(Wall::Motion::kMoving, "velocity", "velocity");
    const Vector v = to_vector(velocity, "velocity");
    if (v.size() != 2 || !v.allFinite()) {
      throw std::invalid_argument(
          fmt::format("velocity has size {}, expected 2 finite numbers", v.size()));
    }
    wall.v = v;
  }
  if (!force.is_none()) {
    require(Wall::Motion::kDriven, "force", "force");
    const auto f = force.cast<double>();
    if (!std::isfinite(f)) throw std::invalid_argument(fmt::format("force = {} is not finite", f));
    wall.force = f;
  }
}

/// Arrays over the disks of a state. `make(data, size, stride)` makes the array.
template <class Class>
void bind_disks(Class& bound) {
  const auto scalars = [](double Disk::*field) {
    return [field](const typename Class::holder_type& self) {
      const std::vector<Disk>& disks = self->state.disks;
      const double* first = disks.empty() ? nullptr : &(disks.front().*field);
      return view_of(first, static_cast<Eigen::Index>(disks.size()), py::cast(self), sizeof(Disk));
    };
  };
  const auto pairs = [](Vec2 Disk::*field) {
    return [field](const typename Class::holder_type& self) {
      const std::vector<Disk>& disks = self->state.disks;
      const double* first = disks.empty() ? nullptr : (disks.front().*field).data();
      return view_of_pairs(first, static_cast<Eigen::Index>(disks.size()), sizeof(Disk),
                           py::cast(self));
    };
  };
  bound.def_property_readonly("positions", pairs(&Disk::x), "(n, 2) [m]")
      .def_property_readonly("velocities", pairs(&Disk::v), "(n, 2) [m/s]")
      .def_property_readonly("angles", scalars(&Disk::angle), "(n,) [rad]")
      .def_property_readonly("spins", scalars(&Disk::spin), "(n,) [rad/s]")
      .def_property_readonly("radii", scalars(&Disk::radius), "(n,) [m]")
      .def_property_readonly("masses", scalars(&Disk::mass), "(n,) [kg]");
}

void bind_state(py::module_& module) {
  py::class_<PythonState, std::shared_ptr<PythonState>> state(
      module, "State", "A copy of where everything is; arrays are read-only views into it.");
  bind_disks(state);
  state
      .def_property_readonly(
          "step", [](const PythonState& s) { return s.state.step; }, "Steps done.")
      .def_property_readonly(
          "time", [](const PythonState& s) { return s.state.time; }, "[s]")
      .def_property_readonly(
          "contacts", [](const PythonState& s) { return contacts_of(s.state); },
          R"(Structured array of the last step's candidates, a copy: i, j (disk j, or wall j - n), n_x,
n_y (from j to i), gap [m], s_n, s_t (on disk i) [N s], u_n, u_t [m/s], status (0 take-off, 1
stick, 2 slip).)")
      .def_property_readonly(
          "walls", [](const PythonState& s) { return walls_of(s.state); },
          "name, shape, motion, a, b [m], normal, velocity [m/s], force [N] of each; copies.");
}

void bind_step(py::module_& module) {
  py::class_<PythonStep, Step> step(module, "Step", "One step that was taken.");
  bind_disks(step);
  const auto of_report = [](auto StepReport::*field) {
    return [field](const PythonStep& s) { return s.report.*field; };
  };
  const auto of_error = [](auto ContactError::*field) {
    return [field](const PythonStep& s) { return s.report.error.*field; };
  };
  step.def_property_readonly("step", of_report(&StepReport::step), "Number of the step.")
      .def_property_readonly("time", of_report(&StepReport::time), "At its end [s].")
      .def_property_readonly("converged", of_report(&StepReport::converged),
                             "Whether the solve met its tolerance.")
      .def_property_readonly("message", of_report(&StepReport::message),
                             "How the solve ended, in words.")
      .def_property_readonly("iterations", of_report(&StepReport::iterations), "Of the solver.")
      .def_property_readonly("penetration", of_report(&StepReport::penetration),
                             "Largest overlap at mid-step [m].")
      .def_property_readonly("solve_seconds", of_report(&StepReport::solve_seconds),
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
          "contacts", [](const PythonStep& s) { return contacts_of(s.state); },
          R"(Structured array of its candidates, a copy: i, j (disk j, or wall j - n), n_x,
n_y (from j to i), gap [m], s_n, s_t (on disk i) [N s], u_n, u_t [m/s], status (0 take-off, 1
stick, 2 slip).)")
      .def_property_readonly(
          "walls", [](const PythonStep& s) { return walls_of(s.state); },
          "name, shape, motion, a, b [m], normal, velocity [m/s], force [N] of each; copies.")
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
            return out;
          },
          "kinetic, potential, wall_work, friction_loss, shock_loss, imbalance, elastic [J].")
      .def("__repr__", [](const PythonStep& s) {
        return fmt::format("<bipot.Step {} at t = {:g} s: {} contacts, {}>", s.report.step,
                           s.report.time, s.report.contacts,
                           s.report.converged ? "converged" : s.report.message);
      });
}

std::unique_ptr<PythonSimulation> make_simulation(
    const std::string& scene, const py::object& solver, std::optional<double> tol,
    std::optional<int> max_iterations, std::optional<bool> warm_start,
    std::map<std::string, std::string> parameters, std::optional<double> step,
    std::optional<int> num_steps, std::optional<double> friction) {
  return std::make_unique<PythonSimulation>(scene,
                                            SimulationChoice{.solver = solver,
                                                             .tol = tol,
                                                             .max_iterations = max_iterations,
                                                             .warm_start = warm_start,
                                                             .parameters = std::move(parameters),
                                                             .step = step,
                                                             .friction = friction,
                                                             .num_steps = num_steps});
}

}  // namespace

void bind_simulation(py::module_& module) {
  py::register_exception<StepFailure>(module, "StepError", PyExc_RuntimeError);
  bind_state(module);
  bind_step(module);
  py::class_<PythonSimulation>(module, "Simulation")
      .def(py::init(&make_simulation), py::arg("scene"), py::arg("solver"), py::arg("tol"),
           py::arg("max_iterations"), py::arg("warm_start"), py::arg("parameters"), py::arg("step"),
           py::arg("num_steps"), py::arg("friction"))
      .def("advance", &PythonSimulation::advance)
      .def_property_readonly("state",
                             [](const PythonSimulation& s) {
                               return std::make_shared<PythonState>(PythonState{s.state()});
                             })
      .def("set_wall", &set_wall, py::arg("wall"), py::arg("velocity"), py::arg("force"))
      .def_property_readonly("title", [](const PythonSimulation& s) { return s.scene().title; })
      .def_property_readonly("time", [](const PythonSimulation& s) { return s.state().time; })
      .def_property_readonly("steps_done", [](const PythonSimulation& s) { return s.state().step; })
      .def_property_readonly("num_steps",
                             [](const PythonSimulation& s) { return s.scene().num_steps; })
      .def_property_readonly("step_size", [](const PythonSimulation& s) { return s.scene().step; })
      .def_property_readonly("walls",
                             [](const PythonSimulation& s) { return walls_of(s.state()); });
}

}  // namespace bipot
