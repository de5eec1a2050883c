#include "bench/tradeoff/window_run.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/observables/measured_bodies.h"
#include "core/scene/contact_detection.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

/// Overlap of each overlapping pair [m].
using Overlaps = std::map<std::pair<int, int>, double>;
Overlaps overlaps_of(const State<2>& state) {
  Overlaps overlaps;
  for (const Contact<2>& c : detect_contacts(state.bodies, state.walls, 0)) {
    if (c.gap < 0) overlaps[{c.i, c.j}] = -c.gap;
  }
  return overlaps;
}

}  // namespace

WindowLength window_length(const Scene<2>& scene, double asked) {
  const double seconds = asked > 0 ? asked : scene.num_steps * scene.step / 50;
  const int fours = std::max(4, static_cast<int>(std::lround(seconds / scene.step / 4)));
  return {4 * fours * scene.step, 4 * fours};
}

void scale_impulses(State<2>& state, double factor) {
  for (ContactOutcome<2>& out : state.contacts) {
    out.s_n *= factor;
    out.s_t *= factor;
  }
}

WindowRun run_window(const Scene<2>& scene, State<2> state, double factor, int steps,
                     const StepSolver& solver, double accepted) {
  scale_impulses(state, factor);
  WindowRun run;
  const double h = scene.step;
  run.force.assign(state.bodies.size() + state.walls.size(), Vec2::Zero());
  const double before = state.friction_loss + state.shock_loss;
  Overlaps overlaps = overlaps_of(state);
  double weights = 0;
  State<2> last;
  int k = 0;
  SceneRunOptions<2> window;
  window.steps = steps;
  window.solver = solver;
  window.before_step = [&last](State<2>& next) { last = next; };
  window.on_step = [&](const SceneStep<2>& step) {
    const StepReport<2>& report = step.report;
    if (!report.converged && !(report.error.guarded() <= accepted)) return false;
    const double weight = 1 - std::abs((2.0 * k + 1) / steps - 1);
    weights += weight * h;
    const auto bodies = measured_bodies(state).list, bodies_before = measured_bodies(last).list;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const MeasuredBody<2>& body = bodies[i];
      run.force[i] += weight * body.mass * (body.v - bodies_before[i].v - h * scene.gravity);
    }
    for (std::size_t w = 0; w < state.walls.size(); ++w) {
      const Wall<2>& wall = state.walls[w];
      if (wall.motion != Wall<2>::Motion::kDriven) continue;
      run.force[bodies.size() + w] +=
          weight * (wall.mass * (wall.v - last.walls[w].v) - h * wall.force * wall.direction);
    }
    Overlaps now = overlaps_of(state);
    for (const auto& [pair, overlap] : now) {
      const auto old = overlaps.find(pair);
      run.penetration =
          std::max(run.penetration, overlap - (old == overlaps.end() ? 0 : old->second));
    }
    overlaps = std::move(now);
    ++k;
    return true;
  };
  if (run_scene(scene, state, window).end != SceneRun<2>::End::kCompleted) return run;
  for (Vec2& f : run.force) f /= weights;
  run.dissipated = state.friction_loss + state.shock_loss - before;
  run.usable = true;
  return run;
}

double energy_floor(const Scene<2>& scene, const State<2>& state) {
  double weight = 0;
  for (const auto& body : measured_bodies(state).list) weight += body.mass * scene.gravity.norm();
  return 1e-3 * std::max(kinetic_energy(state), weight * smallest_radius(scene));
}

Accuracy window_errors(const std::vector<WindowRun>& runs, const std::vector<WindowRun>& reference,
                       double radius, double floor) {
  Accuracy error;
  double energy = 0, energies = 0;
  for (std::size_t w = 0; w < runs.size(); ++w) {
    double apart = 0, largest = 0;
    for (std::size_t b = 0; b < runs[w].force.size(); ++b) {
      apart = std::max(apart, (runs[w].force[b] - reference[w].force[b]).norm());
      largest = std::max(largest, reference[w].force[b].norm());
    }
    if (largest > 0) error.force = std::fmax(error.force, apart / largest);
    error.penetration = std::fmax(error.penetration, runs[w].penetration / radius);
    energy += std::abs(runs[w].dissipated - reference[w].dissipated);
    energies += std::abs(reference[w].dissipated);
  }
  error.energy = energy / std::max(energies, floor);
  return error;
}

StepSolver limited_solver(const SolverEntry& entry, SolverOptions options,
                          std::function<double()> seconds_left) {
  return [&entry, options = std::move(options), seconds_left = std::move(seconds_left)](
             const ContactProblem& p, const Vector& s0) mutable {
    options.time_limit = seconds_left();
    return make_step_solver(entry, options)(p, s0);
  };
}

}  // namespace bipot
