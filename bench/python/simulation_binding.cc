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
#include <utility>
#include <variant>

#include "bench/python/arrays.h"
#include "bench/python/bindings.h"
#include "bench/python/callable_solver.h"
#include "bench/python/python_watch.h"
#include "core/base/counted.h"
#include "core/base/nearest_name.h"
#include "core/run_files/run_output.h"
#include "core/run_files/run_reader.h"
#include "core/scene/wall_motion.h"
#include "core/scene_files/scene_file.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_start.h"
#include "solvers/simulation/scene_stepper.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

namespace py = pybind11;

/// The state at the end of a step, and its report.
template <int D>
struct PythonStep : PythonState<D> {
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
  std::optional<std::filesystem::path> restart;  ///< a run, from whose last frame it goes on
};

/// A scene that Python runs step by step.
template <int D>
class PythonSimulation {
 public:
  /// `text`: of the scene, for its copies.
  PythonSimulation(Scene<D> scene, std::string text, const SimulationChoice& choice)
      : scene_(std::move(scene)), text_(std::move(text)) {
    choose(choice);
    if (choice.restart) {
      go_on_from(*choice.restart);
    } else {
      start_ = check_start(scene_, {}, 1).text;
      state_ = initial_state(scene_);
    }
    if (choice.step && !choice.num_steps) {  // the scene's duration stays
      scene_.num_steps = state_.step + remaining_steps(scene_, state_);
    }
  }
  PythonSimulation(const PythonSimulation&) = delete;  // the stepper looks at the scene
  PythonSimulation& operator=(const PythonSimulation&) = delete;

  const Scene<D>& scene() const { return scene_; }
  const std::string& text() const { return text_; }
  /// What the scene leaves out, and what overlapped at its start.
  std::string caution() const {
    const bool both = !scene_.caution.empty() && !start_.empty();
    return scene_.caution + (both ? "; " : "") + start_;
  }
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
    if (failure && failure->kind == StepFailure::Kind::kInvalidInput && state_.step == 0) {
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

  void go_on_from(const std::filesystem::path& run) {
    state_ = read_state<D>(run);
    if (const std::string mismatch = restart_mismatch(scene_, state_); !mismatch.empty()) {
      throw std::invalid_argument(
          fmt::format("{} does not fit the scene: {}", run.string(), mismatch));
    }
  }

  void choose(const SimulationChoice& choice) {
    if (choice.step) scene_.step = *choice.step;
    if (choice.num_steps) scene_.num_steps = *choice.num_steps;
    if (choice.friction) {
      for (ContactLaw& law : scene_.laws) law.mu = *choice.friction;
    }
    if (std::string defect = validate(scene_); !defect.empty()) throw std::invalid_argument(defect);
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
      if (choice.tol || choice.max_iterations || choice.warm_start || !choice.parameters.empty()) {
        throw std::invalid_argument(
            "tol, max_iterations, warm_start and parameters of solvers have no meaning for springs "
            "and dashpots (model dem): name a solver, which means rigid contacts");
      }
      stepper_.emplace(scene_, SceneRunOptions<D>{.cancelled = cancelled});
      return;
    }
    if (!callable) chosen_.entry = require_solver(own.name);
    SolverOptions options = to_options(own);
    options.cancelled = cancelled;
    stepper_.emplace(
        scene_, SceneRunOptions<D>{.solver = make_step_solver(chosen_.entry, std::move(options))});
  }

  Scene<D> scene_;
  std::string text_;
  std::string start_;  // what overlapped, in a sentence
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
  const auto number = &wall - self.state().walls.data();
  if (has_schedule(self.scene().walls[to_size(number)])) {
    throw std::invalid_argument(fmt::format(
        "wall '{}' moves by the scene's schedule, which Python cannot change", wall.name));
  }
  if (velocity.is_none() && force.is_none()) {
    throw std::invalid_argument("set_wall: give a velocity or a force");
  }
  using Motion = typename Wall<D>::Motion;
  const auto require = [&](Motion motion, const char* what, const char* key) {
    if (wall.motion == motion) return;
    throw std::invalid_argument(
        fmt::format("wall '{}' is {}: a wall with a {} needs {} in the scene", wall.name,
                    motion_name<D>(wall.motion), what, key));
  };
  if (!velocity.is_none()) require(Motion::kMoving, "velocity", "'velocity' without 'force'");
  if (!force.is_none()) require(Motion::kDriven, "force", "'force'");
  if (!velocity.is_none()) {
    const Vector v = to_vector(velocity, "velocity");
    if (v.size() != D || !v.allFinite()) {
      throw std::invalid_argument(
          fmt::format("velocity has size {}, expected {} finite numbers", v.size(), D));
    }
    wall.v = v;
  }
  if (!force.is_none()) {
    const double f = to_number(force, "force");
    if (!std::isfinite(f)) throw std::invalid_argument(fmt::format("force = {} is not finite", f));
    wall.force = f;
  }
}

template <int D>
void bind_step(py::module_& module) {
  using PythonStep = PythonStep<D>;
  py::class_<PythonStep, PythonState<D>, Step<D>> step(module, D == 2 ? "Step" : "SphereStep",
                                                       "One step that was taken.");
  refuse_new(step);
  const auto of_report = [](auto StepReport<D>::*field) {
    return [field](const PythonStep& s) { return s.report.*field; };
  };
  const auto of_error = [](auto ContactError::*field) {
    return [field](const PythonStep& s) { return s.report.error.*field; };
  };
  step.def_property_readonly("converged", of_report(&StepReport<D>::converged),
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
          R"(The contact problem that it solved, of a step in parts the first unsolved or the last one; its
guess is the impulse that the solver started from.)")
      .def_property_readonly(
          "energy",
          [](const PythonStep& s) {
            const EnergyLedger& e = s.report.energy;
            return py::dict(
                py::arg("kinetic") = e.kinetic, py::arg("potential") = e.potential,
                py::arg("wall_work") = e.wall_work, py::arg("friction_loss") = e.friction_loss,
                py::arg("shock_loss") = e.shock_loss, py::arg("imbalance") = e.imbalance,
                py::arg("elastic") = e.elastic, py::arg("cohesion_loss") = e.cohesion_loss,
                py::arg("passed") = e.passed);
          },
          "kinetic, potential, wall_work, friction_loss, shock_loss, imbalance, elastic, cohesion_loss, passed [J].")
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
                           std::optional<double> friction, std::optional<double> accuracy,
                           std::optional<std::filesystem::path> restart) {
  const SimulationChoice choice{.solver = solver,
                                .tol = tol,
                                .max_iterations = max_iterations,
                                .warm_start = warm_start,
                                .parameters = std::move(parameters),
                                .step = step,
                                .friction = friction,
                                .num_steps = num_steps,
                                .restart = std::move(restart)};
  const std::string source = given ? scene : scene_path(scene).string();
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
      .def_property_readonly("caution", &Simulation::caution)
      .def_property_readonly("time", [](const Simulation& s) { return s.state().time; })
      .def_property_readonly("steps_done", [](const Simulation& s) { return s.state().step; })
      .def_property_readonly("num_steps", [](const Simulation& s) { return s.scene().num_steps; })
      .def_property_readonly("step_size", [](const Simulation& s) { return s.scene().step; })
      .def_property_readonly("walls", [](const Simulation& s) { return walls_of<D>(s.state()); });
}

}  // namespace

void bind_simulation(py::module_& module) {
  py::register_exception<StepFailure>(module, "StepError", PyExc_RuntimeError).doc() =
      "The solver of a step failed; the simulation is at the end of the step before.";
  bind_simulation_in<2>(module);
  bind_simulation_in<3>(module);
  module.def("make_simulation", &make_simulation, py::arg("scene"), py::arg("text"),
             py::arg("solver"), py::arg("tol"), py::arg("max_iterations"), py::arg("warm_start"),
             py::arg("parameters"), py::arg("step"), py::arg("num_steps"), py::arg("friction"),
             py::arg("accuracy"), py::arg("restart"));
}

}  // namespace bipot
