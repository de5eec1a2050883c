#include "bench/tradeoff/run_setting.h"

#include <fmt/format.h>

#include <tuple>

#include "bench/measure/stopwatch.h"
#include "bench/report/labels.h"
#include "core/motion/spring_dashpot_setup.h"
#include "core/scene_files/scene_file.h"
#include "solvers/auto/plan.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

}  // namespace

bool RunSetting::operator==(const RunSetting& other) const {
  return std::tie(model, solver, step_factor, accuracy, parameters) ==
             std::tie(other.model, other.solver, other.step_factor, other.accuracy,
                      other.parameters) &&
         same(tol, other.tol) && same(overlap, other.overlap) && same(stiffness, other.stiffness);
}

std::string RunSetting::label() const {
  if (dem()) {
    return std::isfinite(stiffness) ? fmt::format("springs, k_n = {} N/m", value_label(stiffness))
                                    : fmt::format("springs, overlap {}", tolerance_label(overlap));
  }
  const std::string length = step_factor == 1  ? "h"
                             : step_factor < 1 ? fmt::format("h/{:g}", 1 / step_factor)
                                               : fmt::format("{:g} h", step_factor);
  return fmt::format("{}, tol {}, {}", solver, tolerance_label(tol),
                     cut() ? fmt::format("accuracy {:.2g}", accuracy) : length);
}

int steps_of(int steps, const RunSetting& setting) {
  return std::max(1, static_cast<int>(std::lround(steps / setting.step_factor)));
}

template <int D>
int longest_cut_step(const Scene<D>& scene, int steps) {
  if (scene.has_gates()) return 1;
  int longest = 50;
  if (scene.output.every > 0) longest = std::min(longest, scene.output.every);
  if (scene.observables) longest = std::min(longest, scene.observables->every);
  while (steps % longest != 0) --longest;
  return longest;
}

template <int D>
Scene<D> with_setting(Scene<D> scene, const RunSetting& setting) {
  scene.step *= setting.step_factor;
  scene.num_steps = steps_of(scene.num_steps, setting);
  scene.model = setting.model;
  if (setting.cut()) {
    scene.accuracy = setting.accuracy;
    scene.contact_distance =
        std::min(scene.contact_distance, 1e-2 * scene.accuracy * smallest_radius(scene));
  }
  if (std::isfinite(setting.overlap)) scene.dem.overlap = setting.overlap;
  scene.dem.stiffness = std::isfinite(setting.stiffness) ? setting.stiffness : 0;
  return scene;
}

template <int D>
bool run_takes(const Scene<D>& scene, const RunSetting& setting) {
  Scene<D> as_run = with_setting(scene, setting);
  if (scene.contact_distance != default_contact_distance(scene)) {
    as_run.contact_distance = scene.contact_distance;
  }
  return validate(as_run).empty();
}

template <int D>
RunRecord run_setting(const Scene<D>& made, State<D>& state, const RunSetting& setting,
                      const RunLimits& limits, const RunObserver<D>& observer) {
  const Scene<D> scene = with_setting(made, setting);
  RunRecord record{.step = scene.step, .steps_planned = scene.num_steps};
  for (ContactOutcome<D>& out : state.contacts) {
    out.s_n *= setting.step_factor;
    out.s_t *= setting.step_factor;
  }
  const CpuStopwatch watch;
  const auto out_of_time = [&, polls = 0]() mutable {
    if (limits.stopped()) return true;
    // On a few contacts, reading the clock costs more than an iteration.
    return ++polls % 16 == 0 && watch.seconds() > limits.cpu_seconds;
  };
  SceneRunOptions<D> options{
      .steps = scene.num_steps, .cancelled = out_of_time, .before_step = observer.before_step};
  bool gave_up = false;
  if (!setting.dem()) {
    RunSolver solver{.solver = setting.solver,
                     .options = {.tol = setting.tol,
                                 .parameters = setting.parameters,
                                 .plan = named_plan(setting.parameters),
                                 .cancelled = out_of_time}};
    options.solver = [&, solver](const ContactProblem& p, const Vector& s0) mutable {
      solver.watch = Stopwatch();
      if (limits.seconds_left) solver.time_limit = limits.seconds_left();
      const CpuStopwatch clock;
      StepSolution solution = to_step_solution(solver.solve(p, s0));
      if (p.num_contacts() > 0) {
        record.solve_cpu += clock.seconds();
        ++record.solves;
      }
      return solution;
    };
  }
  options.on_step = [&](const SceneStep<D>& step) {
    const double guarded = step.report.error.guarded();
    if (std::isfinite(guarded)) record.worst_guarded = std::fmax(record.worst_guarded, guarded);
    ++record.steps;
    gave_up =
        !step.report.converged && !(guarded <= limits.accepted) && std::isfinite(limits.accepted);
    if (gave_up || (observer.on_step && !observer.on_step(step))) return false;
    return record.steps == scene.num_steps || watch.seconds() <= limits.cpu_seconds;
  };
  SceneRun<D> run;
  try {
    run = run_scene(scene, state, options);
  } catch (const std::invalid_argument& e) {  // springs that the scene does not allow
    record.status = "failed";
    record.message = e.what();
    return record;
  }
  record.cpu = watch.seconds();
  record.simulated = state.time;
  if (run.springs) record.stiffness = run.springs->stiffness;
  record.steps_converged = run.totals.converged;
  record.message = run.failure ? run.failure->what() : run.totals.message;
  if (run.end == SceneRun<D>::End::kFailed) {
    record.status = "failed";
  } else if (gave_up) {
    record.status = "not converged";
  } else if (record.steps == scene.num_steps) {
    record.status = record.steps_converged < record.steps ? "not converged" : "completed";
  } else if (limits.stopped()) {
    record.status = "interrupted";
    record.message = fmt::format("after {} of {} steps", record.steps, scene.num_steps);
  } else {
    record.status = "time limit";
    if (watch.seconds() > limits.cpu_seconds) {
      record.message = fmt::format("{:g} s of CPU time were up", limits.cpu_seconds);
    }
  }
  record.whole = record.steps == scene.num_steps && !gave_up;
  if (record.steps > 0) {
    record.iterations = static_cast<double>(run.totals.iterations) / record.steps;
    record.penetration = run.totals.overlap;
    record.penetration_step = run.totals.overlap_step;
  }
  return record;
}

template int longest_cut_step(const Scene<2>&, int);
template int longest_cut_step(const Scene<3>&, int);
template Scene<2> with_setting(Scene<2>, const RunSetting&);
template Scene<3> with_setting(Scene<3>, const RunSetting&);
template bool run_takes(const Scene<2>&, const RunSetting&);
template bool run_takes(const Scene<3>&, const RunSetting&);
template RunRecord run_setting(const Scene<2>&, State<2>&, const RunSetting&, const RunLimits&,
                               const RunObserver<2>&);
template RunRecord run_setting(const Scene<3>&, State<3>&, const RunSetting&, const RunLimits&,
                               const RunObserver<3>&);

}  // namespace bipot
