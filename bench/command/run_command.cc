#include "bench/command/run_command.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "bench/command/exit_code.h"
#include "bench/command/interrupt.h"
#include "bench/command/progress_bar.h"
#include "bench/report/json_output.h"
#include "bench/scenes/scene_catalogue.h"
#include "core/file_error.h"
#include "core/files/fclib_file.h"
#include "core/files/run_layout.h"
#include "core/files/run_output.h"
#include "core/files/run_reader.h"
#include "core/files/scene_file.h"
#include "core/motion/spring_dashpot.h"
#include "core/motion/stress_tensor.h"
#include "core/motion/time_stepping.h"
#include "core/pictures/force_picture.h"
#include "core/pictures/stress_picture.h"
#include "solvers/registry.h"
#include "solvers/solve.h"
#include "solvers/step_solver.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

/// What the summary says of a whole run.
struct RunTotals {
  int steps = 0, converged = 0;
  long contacts = 0, iterations = 0;
  int max_contacts = 0, max_iterations = 0, worst_step = -1, first_unconverged = -1;
  std::string message;  // of the first step that did not converge
  double worst_error = -1, penetration = 0;
  ContactError worst;
  StepReport last;
  double detection = 0, assembly = 0, solve = 0, output = 0;

  void add(const StepReport& r) {
    ++steps;
    converged += r.converged ? 1 : 0;
    if (!r.converged && first_unconverged < 0) {
      first_unconverged = r.step;
      message = r.message;
    }
    contacts += r.contacts;
    iterations += r.iterations;
    max_contacts = std::max(max_contacts, r.contacts);
    max_iterations = std::max(max_iterations, r.iterations);
    penetration = std::max(penetration, r.penetration);
    const double error = r.error.guarded();
    if (!(error <= worst_error)) {
      worst_error = error;
      worst = r.error;
      worst_step = r.step;
    }
    detection += r.detection_seconds;
    assembly += r.assembly_seconds;
    solve += r.solve_seconds;
    last = r;
  }
};

class Clock {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::string caption(const Scene& scene, const RunTotals& totals, const State& state) {
  if (scene.model == Model::kSpringDashpot) {
    return fmt::format("{}: step {}, t = {:.4g} s, springs and dashpots, {} substeps a step",
                       scene.title.empty() ? scene.source : scene.title, state.step, state.time,
                       totals.last.iterations);
  }
  return fmt::format("{}: step {}, t = {:.4g} s, solver {}, max(ε, η) = {:.1e} (tol {:.0e})",
                     scene.title.empty() ? scene.source : scene.title, state.step, state.time,
                     scene.solver.name, totals.last.error.guarded(), scene.solver.tol);
}

nlohmann::ordered_json summary(const Scene& scene, const SpringDashpotSetup* dem,
                               const RunTotals& t, const State& state, std::string_view status,
                               int exit_code, double wall_seconds) {
  const double steps = std::max(t.steps, 1);
  nlohmann::ordered_json j{{"command", "run"},
                           {"version", BIPOT_VERSION},
                           {"scene", scene.source},
                           {"title", scene.title},
                           {"status", status},
                           {"exit_code", exit_code},
                           {"model", dem != nullptr ? "dem" : "nscd"}};
  if (dem != nullptr) {
    j["dem"] = {{"stiffness", dem->stiffness},
                {"tangential_stiffness", dem->tangential_stiffness},
                {"substep", dem->substep},
                {"critical_step", dem->critical_step},
                {"substeps_per_step", dem->substeps},
                {"departures", dem->departures}};
  } else {
    j["solver"] = scene.solver.name;
    j["tol"] = scene.solver.tol;
    j["stop"] = scene.solver.stop;
  }
  j.update(nlohmann::ordered_json{{"disks", state.disks.size()},
                                  {"steps", t.steps},
                                  {"steps_planned", scene.num_steps},
                                  {"steps_converged", t.converged},
                                  {"message", t.message},
                                  {"first_unconverged_step", t.first_unconverged},
                                  {"time", state.time},
                                  {"contacts_mean", t.contacts / steps},
                                  {"contacts_max", t.max_contacts},
                                  {"iterations_mean", t.iterations / steps},
                                  {"iterations_max", t.max_iterations}});
  add_error(j, t.worst);
  j["worst_step"] = t.worst_step;
  j["penetration"] = t.penetration;
  j["energy"] = {{"kinetic", t.last.energy.kinetic},
                 {"potential", t.last.energy.potential},
                 {"wall_work", t.last.energy.wall_work},
                 {"friction_loss", t.last.energy.friction_loss},
                 {"shock_loss", t.last.energy.shock_loss}};
  if (dem != nullptr) j["energy"]["elastic"] = t.last.energy.elastic;
  const double area = sample_area(state, scene.step);
  if (area > 0) {
    const MeanStress stress = sample_stress(state, scene.step, area, contact_moments(state));
    const Mat2 total = stress.total();
    j["stress"] = {{"xx", total(0, 0)},
                   {"yy", total(1, 1)},
                   {"xy", 0.5 * (total(0, 1) + total(1, 0))},
                   {"pressure", stress.pressure()},
                   {"kinetic_pressure", 0.5 * stress.kinetic.trace()},
                   {"area", area}};
  } else {
    j["stress"] = nullptr;
  }
  j["seconds"] = {{"detection", t.detection},
                  {"assembly", t.assembly},
                  {"solve", t.solve},
                  {"output", t.output},
                  {"total", wall_seconds}};
  return j;
}

void print_summary(const Scene& scene, const SpringDashpotSetup* dem, const RunTotals& t,
                   const State& state, std::string_view status, double wall_seconds,
                   const std::string& out) {
  const double steps = std::max(t.steps, 1);
  fmt::print("{}\n", scene.title.empty() ? scene.source : scene.title);
  fmt::print("  status       {}: {} of {} steps, {} converged, t = {:.6g} s\n", status, t.steps,
             scene.num_steps, t.converged, state.time);
  if (!t.message.empty()) fmt::print("  reason       {}\n", t.message);
  if (dem != nullptr) {
    fmt::print(
        "  model        springs and dashpots, k_n = {:.4g} N/m, k_t = {:.4g} N/m\n"
        "  substeps     {} a step of {:.4g} s; stable up to {:.4g} s\n",
        dem->stiffness, dem->tangential_stiffness, dem->substeps, dem->substep, dem->critical_step);
    for (const std::string& line : dem->departures) fmt::print("  note         {}\n", line);
  } else {
    fmt::print("  solver       {} to {} {:.0e}\n", scene.solver.name, scene.solver.stop,
               scene.solver.tol);
  }
  fmt::print("  contacts     mean {:.1f}, max {}\n", t.contacts / steps, t.max_contacts);
  if (dem == nullptr) {
    fmt::print("  iterations   mean {:.1f}, max {}\n", t.iterations / steps, t.max_iterations);
    fmt::print("  worst error  {:.2e} in step {} (ε {:.2e}, η {:.2e}, raw (42) {:.2e})\n",
               t.worst.guarded(), t.worst_step, t.worst.epsilon, t.worst.eta, t.worst.raw42);
  }
  fmt::print("  penetration  max {:.3e} m\n", t.penetration);
  fmt::print(
      "  energy       kinetic {:.4e} J, potential {:.4e} J, wall work {:.4e} J,\n"
      "               lost to friction {:.4e} J, to shocks {:.4e} J\n",
      t.last.energy.kinetic, t.last.energy.potential, t.last.energy.wall_work,
      t.last.energy.friction_loss, t.last.energy.shock_loss);
  fmt::print(
      "  wall time    {:.2f} s: detection {:.2f}, assembly {:.2f}, solve {:.2f}, output "
      "{:.2f}\n",
      wall_seconds, t.detection, t.assembly, t.solve, t.output);
  if (!out.empty()) fmt::print("  results in   {}\n", out);
}

/// A flag without effect would mislead.
void refuse_flags_of_the_other_model(const RunFlags& flags, Model model) {
  const SolverFlags& solver = flags.solver;
  if (model == Model::kSpringDashpot) {
    const char* flag = solver.name                    ? "--solver"
                       : solver.stop                  ? "--stop"
                       : solver.tol                   ? "--tol"
                       : solver.max_iterations        ? "--max-iterations"
                       : solver.warm_start            ? "--warm-start"
                       : !solver.parameters.empty()   ? "a solver parameter"
                       : !flags.dump_problems.empty() ? "--dump-problems"
                                                      : nullptr;
    if (flag != nullptr) {
      throw std::invalid_argument(fmt::format(
          "{} has no meaning under --model dem, which solves no contact problem", flag));
    }
    if (flags.stiffness && flags.overlap) {
      throw std::invalid_argument("give --stiffness or --overlap: one decides the other");
    }
    return;
  }
  const char* flag = flags.stiffness          ? "--stiffness"
                     : flags.overlap          ? "--overlap"
                     : flags.tangential_ratio ? "--tangential-ratio"
                     : flags.substep          ? "--substep"
                                              : nullptr;
  if (flag != nullptr) {
    throw std::invalid_argument(
        fmt::format("{} has no meaning under --model nscd, whose contacts are rigid", flag));
  }
}

/// The scene with the command line's changes, checked before anything is written.
Scene load_scene(const RunFlags& flags, std::string& text) {
  const fs::path path = find_scene(flags.scene);
  std::ifstream file(path);
  std::ostringstream content;
  content << file.rdbuf();
  text = content.str();
  Scene scene = parse_scene(text, path.string());
  if (flags.steps) scene.num_steps = *flags.steps;
  if (flags.step_size) scene.step = *flags.step_size;
  scene.solver = merged(scene.solver, flags.solver);
  if (flags.model) {
    scene.model = *flags.model == "dem" ? Model::kSpringDashpot : Model::kNonsmooth;
  }
  refuse_flags_of_the_other_model(flags, scene.model);
  if (flags.stiffness) scene.dem.stiffness = *flags.stiffness;
  if (flags.overlap) {
    scene.dem.overlap = *flags.overlap;
    scene.dem.stiffness = 0;
  }
  if (flags.tangential_ratio) scene.dem.tangential_ratio = *flags.tangential_ratio;
  if (flags.substep) scene.dem.substep = *flags.substep;
  if (auto defect = validate(scene); !defect.empty()) throw std::invalid_argument(defect);
  return scene;
}

void dump_problem(const fs::path& folder, const Scene& scene, const StepReport& report,
                  const ContactProblem& problem) {
  if (problem.num_contacts() == 0) return;
  fs::create_directories(folder);
  const fs::path path = folder / fmt::format("step_{:06d}.hdf5", report.step);
  write_fclib(path, problem,
              {.title = fmt::format("{}, step {}", scene.title, report.step),
               .description = fmt::format(
                   "bipot {}, scene {}, step {} at t = {} s, h = {} s; solver {}: {}",
                   BIPOT_VERSION, fs::path(scene.source).filename().string(), report.step,
                   report.time, scene.step, scene.solver.name, report.message)});
}

}  // namespace

CLI::App* add_run_command(CLI::App& app, RunFlags& flags) {
  CLI::App* command =
      app.add_subcommand("run", "Run a scene: time steps, files, pictures, summary");
  command->add_option("scene", flags.scene, "Scene file (TOML) or the name of a shipped scene")
      ->required();
  command->add_option("--steps", flags.steps, "Number of steps, instead of the scene's")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--step-size", flags.step_size, "Time step in s, instead of the scene's")
      ->check(CLI::PositiveNumber);
  command->add_option("--restart", flags.restart, "Continue from the last frame of a run.h5")
      ->type_name("FILE");
  command
      ->add_option("--dump-problems", flags.dump_problems,
                   "Write the steps' contact problems as FCLIB files into DIR/problems")
      ->check(CLI::IsMember({"all", "failed"}));
  command
      ->add_option("--model", flags.model,
                   "nscd: rigid disks, exact contact laws, one implicit problem a step; dem: "
                   "springs and dashpots (Cundall and Strack), explicit substeps")
      ->check(CLI::IsMember({"nscd", "dem"}));
  const auto dem = [&](const char* name, std::optional<double>& value, const char* unit,
                       const char* help) {
    command->add_option(name, value, help)->type_name(unit)->group("Model dem");
  };
  dem("--stiffness", flags.stiffness, "N/m", "Normal stiffness (default: by --overlap)");
  dem("--overlap", flags.overlap, "FRACTION",
      "Overlap aimed at, of the smallest radius; decides the stiffness");
  dem("--tangential-ratio", flags.tangential_ratio, "FRACTION", "Tangential over normal stiffness");
  dem("--substep", flags.substep, "SECONDS",
      "Largest substep (default: from the stability limit); refused where unstable");
  add_common_flags(*command, flags.common);
  add_solver_flags(*command, flags.solver);
  add_warm_start_flags(*command, flags.solver);
  command->footer(
      "Examples:\n"
      "  bipot run compaction --out out/compaction\n"
      "  bipot run square_lattice --solver uzawa --rho paper --tol 1e-6 --json -\n"
      "  bipot run compaction --out out/b --restart out/a/run.h5 --steps 100\n"
      "  bipot run compaction --out out/c --dump-problems failed\n"
      "  bipot run compaction --out out/d --model dem --overlap 1e-4");
  return command;
}

int run_command(const RunFlags& flags) {
  std::string text;
  const Scene scene = load_scene(flags, text);
  const bool dem = scene.model == Model::kSpringDashpot;
  const SolverEntry& entry = require_solver(dem ? SolverChoice{}.name : scene.solver.name);
  SolverOptions options = to_options(dem ? SolverChoice{} : scene.solver);
  // A first look at the options on a problem without contacts: wrong ones are refused here.
  if (const SolveResult probe = solve(entry, ContactProblem{}, options);
      probe.status == SolveStatus::kInvalidInput) {
    throw std::invalid_argument(probe.message);
  }
  if (flags.common.out.empty() && !flags.dump_problems.empty()) {
    throw std::invalid_argument("--dump-problems needs --out DIR");
  }

  if (dem) spring_dashpot_setup(scene);  // refuses before anything is written

  const Clock clock;
  const fs::path out = flags.common.out;
  State state = flags.restart.empty() ? initial_state(scene) : read_state(flags.restart);
  if (const std::string mismatch = restart_mismatch(scene, state); !mismatch.empty()) {
    throw std::invalid_argument(flags.restart + " does not fit the scene: " + mismatch);
  }
  std::unique_ptr<RunWriter> writer;
  if (!out.empty()) {
    const bool same_folder =
        !flags.restart.empty() && fs::exists(out) && fs::equivalent(out, run_folder(flags.restart));
    writer = std::make_unique<RunWriter>(out, scene, text, same_folder ? state.step : -1);
    writer->frame(state);
  }

  require_writable(flags.common.json);  // may lie in the folder that was just made

  const InterruptGuard interrupt;
  const bool json_on_stdout = flags.common.json == "-";
  const bool quiet = flags.common.quiet || json_on_stdout;
  RunTotals totals;
  SpringDashpotSetup setup;  // dem only
  std::string_view status = "completed";
  std::string failure;
  int exit_code = kExitConverged;
  {
    const double limit = flags.common.time_limit;
    std::optional<SpringDashpotStepper> springs;
    if (dem) {
      springs.emplace(scene,
                      [&] { return InterruptGuard::requested() || clock.seconds() > limit; });
      setup = springs->setup();
    }
    TimeStepper stepper(
        scene,
        [&](const ContactProblem& problem, const Vector& s0) {
          options.time_limit = std::max(limit - clock.seconds(), 1e-3);
          options.cancelled = &InterruptGuard::requested;
          return make_step_solver(entry, options)(problem, s0);
        },
        entry.needs_delassus);
    ProgressBar progress(scene.num_steps, quiet);
    bool framed = true;
    for (int k = 1; k <= scene.num_steps; ++k) {
      StepReport report;
      try {
        report = springs ? springs->advance(state) : stepper.advance(state);
      } catch (const StepFailure& e) {
        failure = e.what();
        if (e.kind == StepFailure::Kind::kInvalidInput) {
          status = "invalid input";
          exit_code = kExitBadInput;
        } else if (e.kind == StepFailure::Kind::kNumerical) {
          status = "failed";
          exit_code = kExitNumericalFailure;
        } else if (InterruptGuard::requested()) {
          status = "interrupted";
          exit_code = kExitInterrupted;
        } else {
          status = "time limit";
          exit_code = kExitNotConverged;
        }
        if (!flags.dump_problems.empty()) {
          StepReport failed;
          failed.step = state.step + 1;
          failed.message = failure;
          dump_problem(out / "problems", scene, failed, stepper.problem());
        }
        break;
      }
      totals.add(report);
      const double before_output = clock.seconds();
      if (flags.dump_problems == "all" || (flags.dump_problems == "failed" && !report.converged)) {
        dump_problem(out / "problems", scene, report, stepper.problem());
      }
      if (writer) {
        writer->step(state, report);
        framed = scene.output.every > 0 && state.step % scene.output.every == 0;
        if (framed) writer->frame(state);
      }
      totals.output += clock.seconds() - before_output;
      progress.update(
          k, fmt::format("{} contacts, {} iterations", report.contacts, report.iterations));
      if (InterruptGuard::requested()) {
        status = "interrupted";
        exit_code = kExitInterrupted;
        break;
      }
      if (k < scene.num_steps && clock.seconds() > limit) {
        status = "time limit";
        exit_code = kExitNotConverged;
        break;
      }
    }
    const double before_output = clock.seconds();
    if (writer) {
      if (!framed) writer->frame(state);
      writer->close();
      if (scene.output.picture) {
        const std::string text_below = caption(scene, totals, state);
        draw_force_picture(out / "forces.svg", scene, state, text_below);
        draw_force_picture(out / "forces.png", scene, state, text_below);
      }
      if (scene.output.stress_picture) {
        const std::vector<double> pressures = disk_pressures(state, scene.step);
        const std::string text_below = caption(scene, totals, state);
        draw_stress_picture(out / "stress.svg", scene, state, pressures, text_below);
        draw_stress_picture(out / "stress.png", scene, state, pressures, text_below);
      }
    }
    totals.output += clock.seconds() - before_output;
  }
  if (exit_code == kExitConverged && totals.converged < totals.steps) {
    status = "not converged";
    exit_code = kExitNotConverged;
  }
  if (!failure.empty()) totals.message = failure;
  if (!failure.empty()) fmt::print(stderr, "bipot: {}\n", failure);
  const SpringDashpotSetup* shown = dem ? &setup : nullptr;
  const auto json = summary(scene, shown, totals, state, status, exit_code, clock.seconds());
  if (!out.empty()) write_json(json, (out / "summary.json").string());
  if (!flags.common.json.empty()) write_json(json, flags.common.json);
  if (!quiet) print_summary(scene, shown, totals, state, status, clock.seconds(), out.string());
  return exit_code;
}

}  // namespace bipot
