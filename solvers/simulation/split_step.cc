#include "solvers/simulation/split_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/motion/population.h"
#include "core/motion/step_outcome.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

/// Both lists are sorted by (i, j). Frames, velocities and statuses are those of the later part.
template <int D>
std::vector<ContactOutcome<D>> added(const std::vector<ContactOutcome<D>>& first,
                                     const std::vector<ContactOutcome<D>>& second) {
  const auto key = [](const ContactOutcome<D>& c) { return std::pair(c.contact.i, c.contact.j); };
  std::vector<ContactOutcome<D>> sum;
  auto a = first.begin();
  for (const ContactOutcome<D>& b : second) {
    for (; a != first.end() && key(*a) < key(b); ++a) sum.push_back(*a);
    ContactOutcome<D> both = b;
    if (a != first.end() && key(*a) == key(b)) {
      both.s_n += a->s_n;
      both.s_t += a->s_t;
      ++a;
    }
    sum.push_back(both);
  }
  sum.insert(sum.end(), a, first.end());
  return sum;
}

/// The parts of one step so far.
template <int D>
class Parts {
 public:
  Parts(const Scene<D>& scene, const SceneRunOptions<D>& options, State<D> start)
      : scene_(scene), options_(options), state_(std::move(start)) {}

  void take(double h, int halvings) {
    Scene<D> part = scene_;
    part.step = h;
    part.outlets.clear();  // bodies come and go between whole steps
    part.inlets.clear();
    TimeStepper<D> stepper(part, options_.solver, options_.explicit_delassus, options_.threads);
    if (options_.on_tunnel != OnTunnel::kWarn) stepper.refuse_passages();
    const bool accept = options_.on_failure == OnFailure::kContinue ||
                        options_.on_failure == OnFailure::kUnlessUnsolvable;
    State<D> next = state_;
    std::string why;
    try {
      const StepReport<D> report = stepper.advance(next);
      if (report.converged || accept) {
        add(report, std::move(next));
        return;
      }
      attempts_.add_cost(report);
      why = report.message;
    } catch (const StepFailure& failure) {
      if (failure.kind == StepFailure::Kind::kPassage) {
        if (options_.on_tunnel != OnTunnel::kSmallerStep || halvings == 0) throw;
      } else if (failure.kind != StepFailure::Kind::kNumerical || accept) {
        throw;
      }
      why = failure.what();
    }
    if (halvings == 0) {
      throw StepFailure(StepFailure::Kind::kNotConverged, state_,
                        fmt::format("not solved with a step of {:.3g} s either: {}", h, why));
    }
    take(0.5 * h, halvings - 1);
    take(0.5 * h, halvings - 1);
  }

  SplitStep<D> finish(State<D>& state) {
    const int step = state.step + 1;
    const double time = time_after_step(state, scene_.step);
    state = std::move(state_);
    state.contacts = std::move(contacts_);
    state.step = total_.step = step;
    state.time = total_.time = time;
    total_.wall_pushes = wall_pushes(state.contacts, state.bodies.size());
    total_.add_cost(attempts_);
    return {std::move(total_), parts_};
  }

 private:
  void add(const StepReport<D>& part, State<D> next) {
    const StepReport<D> before = std::exchange(total_, part);
    if (parts_++ > 0) {
      total_.add_cost(before);
      if (!before.converged) {
        total_.converged = false;
        total_.message = before.message;
      }
      total_.energy.imbalance += before.energy.imbalance;
      total_.momentum_imbalance += before.momentum_imbalance;
      total_.unsolvable = total_.unsolvable || before.unsolvable;
      total_.penetration = std::max(total_.penetration, before.penetration);
      if (before.overlap > total_.overlap) {
        total_.overlap = before.overlap;
        total_.overlap_pair = before.overlap_pair;
      }
      total_.travel += before.travel;
      total_.passages += before.passages;
      if (before.passages > 0) total_.passage = before.passage;
      total_.contacts = std::max(total_.contacts, before.contacts);
      total_.active = std::max(total_.active, before.active);
      if (before.error.guarded() > total_.error.guarded()) total_.error = before.error;
    }
    contacts_ = added(contacts_, next.contacts);
    state_ = std::move(next);
  }

  const Scene<D>& scene_;
  const SceneRunOptions<D>& options_;
  State<D> state_;
  StepReport<D> total_, attempts_;  // of the parts taken; the cost of the others
  std::vector<ContactOutcome<D>> contacts_;
  int parts_ = 0;
};

}  // namespace

template <int D>
SplitStep<D> advance_in_parts(const Scene<D>& scene, const SceneRunOptions<D>& options,
                              State<D>& state) {
  Parts<D> parts(scene, options, with_changed_population(scene, state));
  parts.take(0.5 * scene.step, kMostHalvings - 1);
  parts.take(0.5 * scene.step, kMostHalvings - 1);
  return parts.finish(state);
}

template <int D>
int travel_halvings(const Scene<D>& scene, const State<D>& state) {
  if (scene.travel == 0 || state.bodies.empty()) return 0;
  const Vec<D> gained = scene.step * gravity_at(scene, state.time + 0.5 * scene.step);
  double speed = 0, radius = kInfinity;
  for (const Body<D>& d : state.bodies) {
    const bool free = d.wall < 0;
    speed = std::max({speed, d.v.norm(), free ? Vec<D>(d.v + gained).norm() : 0.0});
    radius = std::min(radius, d.radius);
  }
  for (const Wall<D>& w : walls_at(scene.walls, state.walls, state.time + 0.5 * scene.step)) {
    const bool driven = w.motion == Wall<D>::Motion::kDriven;
    speed = std::max(speed, w.v.norm() + (driven ? scene.step * std::abs(w.force) / w.mass : 0));
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

template <int D>
SplitStep<D> advance_in_equal_parts(const Scene<D>& scene, const SceneRunOptions<D>& options,
                                    State<D>& state, int halvings) {
  Parts<D> parts(scene, options, with_changed_population(scene, state));
  const int count = 1 << halvings;
  const bool further =
      options.on_failure == OnFailure::kSmallerStep || options.on_tunnel == OnTunnel::kSmallerStep;
  for (int k = 0; k < count; ++k) parts.take(scene.step / count, further ? kMostHalvings : 0);
  return parts.finish(state);
}

template int travel_halvings(const Scene<2>&, const State<2>&);
template int travel_halvings(const Scene<3>&, const State<3>&);
template SplitStep<2> advance_in_equal_parts(const Scene<2>&, const SceneRunOptions<2>&, State<2>&,
                                             int);
template SplitStep<3> advance_in_equal_parts(const Scene<3>&, const SceneRunOptions<3>&, State<3>&,
                                             int);
template SplitStep<2> advance_in_parts(const Scene<2>&, const SceneRunOptions<2>&, State<2>&);
template SplitStep<3> advance_in_parts(const Scene<3>&, const SceneRunOptions<3>&, State<3>&);

}  // namespace bipot
