#include "solvers/simulation/split_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/motion/body_forces.h"
#include "core/motion/population.h"
#include "core/scene/wall_motion.h"
#include "solvers/simulation/summed_parts.h"

namespace bipot {
namespace {

// A solve with fewer is easy: a part of twice the length may succeed.
constexpr int kEasyIterations = kAttemptIterations / 3;

/// The parts of one step so far.
template <int D>
class Parts {
 public:
  Parts(const Scene<D>& scene, const SceneRunOptions<D>& options, State<D> start)
      : scene_(scene), options_(options), state_(std::move(start)) {}

  void take(double h, int halvings, int most_halvings) {
    Scene<D> part = part_of(scene_);
    part.step = h;
    TimeStepper<D> stepper(part, options_.solver, options_.threads);
    if (options_.on_tunnel != OnTunnel::kWarn) stepper.refuse_passages();
    const bool accept = options_.takes_unsolved();
    State<D> next = state_;
    scale_impulses(next.contacts, h / contacts_step_);
    std::string why;
    try {
      const StepReport<D> report = stepper.advance(next);
      if (report.converged || accept) {
        const int whole_steps = state_.step;  // messages count these
        state_ = std::move(next);
        state_.step = whole_steps;
        contacts_step_ = h;
        deepest_ = std::max(deepest_, halvings);
        iterations_ = std::max(iterations_, report.iterations);
        sums_.add(report, state_.contacts);
        return;
      }
      sums_.add_rejected(report);
      why = report.message;
    } catch (const StepFailure& failure) {
      const bool splits =
          (failure.is_of_places() && options_.on_tunnel == OnTunnel::kSmallerStep) ||
          (failure.may_yield() && !accept);
      const bool unsolved = failure.kind == StepFailure::Kind::kNumerical;
      if (!splits || (halvings == most_halvings && !unsolved)) throw;
      why = failure.what();
    }
    if (halvings == most_halvings) {
      throw StepFailure(StepFailure::Kind::kNotConverged, state_,
                        fmt::format("not solved with a part of {:.3g} s: {}", h, why));
    }
    take(0.5 * h, halvings + 1, most_halvings);
    take(0.5 * h, halvings + 1, most_halvings);
  }

  SplitStep<D> finish(State<D>& state) {
    const State<D> before = std::exchange(state, std::move(state_));
    const int parts = sums_.count();
    const int next = deepest_ - (iterations_ <= kEasyIterations ? 1 : 0);
    return {sums_.finish(before, scene_.step, state), parts, next};
  }

 private:
  const Scene<D>& scene_;
  const SceneRunOptions<D>& options_;
  State<D> state_;
  SummedParts<D> sums_;
  double contacts_step_ = scene_.step;  // in which the impulses of state_ arose          [s]
  int deepest_ = 0, iterations_ = 0;    // largest of the parts taken: halvings, iterations
};

}  // namespace

template <int D>
SplitStep<D> advance_in_parts(const Scene<D>& scene, const SceneRunOptions<D>& options,
                              State<D>& state, int halvings, int most_halvings) {
  Parts<D> parts(scene, options, with_changed_population(scene, state));
  const int count = 1 << halvings;
  for (int k = 0; k < count; ++k) parts.take(scene.step / count, halvings, most_halvings);
  return parts.finish(state);
}

template <int D>
int travel_halvings(const Scene<D>& scene, const State<D>& state) {
  if (scene.travel == 0 || state.bodies.empty()) return 0;
  const double middle = state.time + 0.5 * scene.step, end = state.time + scene.step;
  const Vec<D> gained = scene.step * gravity_at(scene, middle);
  std::vector<Vec<D>> v_free;
  for (const Body<D>& d : state.bodies) v_free.emplace_back(d.v + gained);
  if (has_body_forces(scene)) {
    add_body_forces<D>(scene, state.cell, middle, state.bodies, v_free);
  }
  double speed = 0, radius = kInfinity;
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const Body<D>& d = state.bodies[i];
    const Vec<D> of_image = image_velocity(state.cell, d.x);
    speed = std::max(
        {speed, (d.v - of_image).norm(), d.wall < 0 ? (v_free[i] - of_image).norm() : 0.0});
    radius = std::min(radius, d.radius);
  }
  const std::vector<Wall<D>> walls = walls_at(scene.walls, state.walls, middle);
  for (std::size_t w = 0; w < walls.size(); ++w) {
    using Motion = typename Wall<D>::Motion;
    const Wall<D>&wall = walls[w], &whole = scene.walls[w];
    if (!has_schedule(whole)) {
      const bool driven = wall.motion == Motion::kDriven;
      const double gain = driven ? scene.step * std::abs(wall.force) / wall.mass : 0;
      speed = std::max(speed, wall.v.norm() + gain);
      continue;
    }
    const double stops = std::min(whole.stops, whole.removed);
    if (!(whole.starts < end && stops > state.time)) continue;
    const double factor = whole.time_factor.largest(state.time, end);
    speed = std::max(speed,
                     whole.motion == Motion::kDriven
                         ? wall.v.norm() + scene.step * factor * std::abs(whole.force) / whole.mass
                         : factor * whole.v.norm());
  }
  double way = scene.step * speed;
  for (int halvings = 0; halvings <= kMostTravelHalvings; ++halvings, way *= 0.5) {
    if (way <= scene.travel * radius) return halvings;
  }
  throw StepFailure(
      StepFailure::Kind::kInvalidInput, state,
      fmt::format(
          "a body or wall at {:.3g} m/s goes farther than travel = {:g} of the smallest radius "
          "even in a part of 1/{} of the step: give a smaller step",
          speed, scene.travel, 1 << kMostTravelHalvings));
}

template int travel_halvings(const Scene<2>&, const State<2>&);
template int travel_halvings(const Scene<3>&, const State<3>&);
template SplitStep<2> advance_in_parts(const Scene<2>&, const SceneRunOptions<2>&, State<2>&, int,
                                       int);
template SplitStep<3> advance_in_parts(const Scene<3>&, const SceneRunOptions<3>&, State<3>&, int,
                                       int);

}  // namespace bipot
