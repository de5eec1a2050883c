#include "solvers/simulation/accurate_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "core/motion/closing_pairs.h"
#include "core/motion/population.h"
#include "core/scene/wall_motion.h"
#include "solvers/simulation/summed_parts.h"

namespace bipot {
namespace {

constexpr double kFirst = 0.1;              // part of a step, over the step
constexpr double kSmallest = 0x1p-20;       // likewise
constexpr double kSlack = 1.5;              // errors up to this multiple of the accuracy are taken
constexpr double kAim = 0.9;                // of the accuracy, where smooth motion decides
constexpr double kGrowth = 3, kDrop = 0.2;  // from a part to the next
constexpr double kHit = 0.02;               // of the accuracy: from here on a part had an impact
constexpr double kApproach = 10;            // drift by a velocity that only an impact leaves
constexpr double kEnd = 1e-9;               // relative; a part that nearly reaches the end does

/// An entry of a list that is sorted by (i, j), or null.
template <int D>
const ContactOutcome<D>* find_pair(const std::vector<ContactOutcome<D>>& contacts, int i, int j) {
  const auto at = std::lower_bound(contacts.begin(), contacts.end(), std::pair(i, j),
                                   [](const ContactOutcome<D>& c, const std::pair<int, int>& key) {
                                     return c.contact.pair() < key;
                                   });
  const bool found = at != contacts.end() && at->contact.pair() == std::pair(i, j);
  return found ? &*at : nullptr;
}

template <int D>
bool pushed(const std::vector<ContactOutcome<D>>& contacts, int i, int j) {
  const ContactOutcome<D>* c = find_pair(contacts, i, j);
  return c != nullptr && c->status != ContactStatus::kTakeOff;
}

/// Whether a wall starts or stops now: its velocity jumps.
template <int D>
bool a_wall_jumps(const Scene<D>& scene, double time, double resolution) {
  return std::any_of(scene.walls.begin(), scene.walls.end(), [&](const Wall<D>& wall) {
    return (wall.starts > 0 && std::abs(time - wall.starts) <= resolution) ||
           std::abs(time - wall.stops) <= resolution;
  });
}

/// The next time at which a wall, gravity or the rate of a force changes by schedule.
template <int D>
double next_change(const Scene<D>& scene, double time, double resolution) {
  double next = kInfinity;
  const auto add = [&](double at) {
    if (at > time + resolution) next = std::min(next, at);
  };
  const auto add_table = [&](const TimeFactor& factor) {
    const auto& times = factor.times;
    const auto after = std::upper_bound(times.begin(), times.end(), time + resolution);
    if (after != times.end()) add(*after);
  };
  for (const Wall<D>& wall : scene.walls) {
    for (const double at : {wall.starts, wall.stops, wall.removed}) add(at);
    add_table(wall.time_factor);
  }
  for (const BodyForce<D>& force : scene.forces) add_table(force.time_factor);
  if (scene.tilt.rate != 0) {
    add(scene.tilt.starts);
    add(scene.tilt.stops);
  }
  return next;
}

/// Of the fastest wall or force that swings [s]. Over a whole period its mean is zero: parts of a
/// quarter see it.
template <int D>
double quarter_period(const Scene<D>& scene) {
  double fastest = 0;
  for (const Wall<D>& wall : scene.walls) {
    fastest = std::max(fastest, wall.time_factor.frequency);
  }
  for (const BodyForce<D>& force : scene.forces) {
    fastest = std::max(fastest, force.time_factor.frequency);
  }
  return fastest > 0 ? 0.25 / fastest : kInfinity;
}

}  // namespace

/// What a part of a step did wrong, over the accuracy.
template <int D>
struct AccurateStepper<D>::Error {
  double misplaced = 0;  // largest displacement by an impact
  int i = -1, j = -1;    // the pair
  double drift = 0, acceleration = 0;
  bool hit = false;  // it had an impact, or a wall jumped

  double smooth() const { return std::max(drift, acceleration); }
  const char* smooth_kind() const { return drift > acceleration ? "drift" : "acceleration"; }
};

/// A step under way. Accelerations are judged against those of the part before: from the start, or
/// the last impact, on. Until a second part has been judged, the step can go back there.
template <int D>
struct AccurateStepper<D>::Step {
  /// How far it is.
  struct Reached {
    State<D> now;
    StepParts cut;
    double shortest = 0;  // of all parts
    double last = 0;      // size of the last one, of its impulses
    double done = 0;      // time of the parts so far
  };
  Step(const Scene<D>& scene, const State<D>& state)
      : start(state),
        at{state, {.smallest = kInfinity}, scene.step, scene.step},
        smooth(kFirst * scene.step) {
    set_mark();
  }
  void set_mark() {
    sums.add(since);
    since = {};
    first = smooth;
    mark = at;
  }
  void go_back() {
    const StepParts tried = std::exchange(at, mark).cut;
    at.cut.misplacing = tried.misplacing;
    at.cut.drifting = tried.drifting;
    at.cut.accelerating = tried.accelerating + since.count();
    at.cut.failed = tried.failed;
    since.reject_all();
    smooth = first = std::min(smooth, 0.5 * first);
    a.reset();
  }
  const State<D> start;
  Reached at, mark;
  SummedParts<D> sums, since;         // parts up to the mark, and since
  double smooth;                      // size that smooth motion allows
  double first = 0;                   // of the first part after the mark
  std::string smooth_by = "none";     // why
  double shrink = 1;                  // after rejected parts
  std::string shrunk_by;              // why
  std::optional<Accelerations<D>> a;  // of the last part, if it had no impact
  bool jump = false;                  // of a wall, now
};

template <int D>
struct AccurateStepper<D>::Part {
  double h;
  bool ends;                         // the step, or a time of a scheduled change
  std::string by;                    // what limits it
  std::vector<Closing<D>> closings;  // within it, and maybe later
};

template <int D>
AccurateStepper<D>::AccurateStepper(const Scene<D>& scene, const SceneRunOptions<D>& options,
                                    StepSolver solver, std::function<bool()> is_over)
    : scene_(scene),
      options_(options),
      is_over_(std::move(is_over)),
      part_(part_of(scene)),
      stepper_(part_, std::move(solver), options.threads),
      closings_(part_, options.threads),
      longest_(quarter_period(scene)),
      radius_(smallest_radius(scene)) {
  stepper_.refuse_passages();
}

/// "impact 3 7" with the numbers of bodies, "impact 3 floor" with the name of a wall.
template <int D>
std::string AccurateStepper<D>::impact(const State<D>& state, int i, int j) const {
  const std::size_t bodies = state.bodies.size();
  return fmt::format("impact {} {}", body_number(state, i),
                     to_size(j) < bodies ? fmt::format("{}", body_number(state, j))
                                         : scene_.walls[to_size(j) - bodies].name);
}

/// Shortens h so that the first collision that matters is in the middle of this part or, where that
/// would be too long, of the next. Returns which, or nothing.
template <int D>
std::string AccurateStepper<D>::place(const State<D>& now, const std::vector<Closing<D>>& closing,
                                      double& h) const {
  const Closing<D>* limit = nullptr;
  for (const Closing<D>& c : closing) {
    if (c.time >= h) break;
    const double most = scene_.accuracy * pair_radius(now.bodies, now.walls, c.i, c.j) /
                        (1 + pair_law(scene_, now.bodies, now.walls, c.i, c.j).e_n);
    if (c.speed * h <= most) continue;
    const double at_impact = most / c.speed;
    limit = &c;
    if (c.time <= at_impact) {
      h = at_impact;
      continue;
    }
    // The first half of a part is straight. A pair that is accelerated towards each other would be
    // apart by -c h²/8 in the middle, and noticed a part too late.
    const double late = std::max(0.0, -c.bend) * at_impact * at_impact / (8 * c.speed);
    h = c.time - 0.5 * at_impact + std::min(late + 0.01 * at_impact, 0.25 * at_impact);
  }
  return limit == nullptr ? std::string() : impact(now, limit->i, limit->j);
}

/// The speed at which a pair that touches approaches where a part begins, else 0. `closings` are
/// sorted.
template <int D>
double approach_speed(const std::vector<Closing<D>>& closings, int i, int j) {
  const auto at =
      std::lower_bound(closings.begin(), closings.end(), std::tuple(0.0, i, j),
                       [](const Closing<D>& c, const std::tuple<double, int, int>& key) {
                         return std::tuple(c.time, c.i, c.j) < key;
                       });
  const bool found = at != closings.end() && at->time == 0 && at->i == i && at->j == j;
  return found ? at->speed : 0;
}

/// Compares the states before and after a part of size h. The size of the part before it counts for
/// drift: after a start from rest or an impact, velocities are along contacts as they were in its
/// middle, and no short part undoes that.
template <int D>
auto AccurateStepper<D>::measure(const Step& step, const Part& taken, const State<D>& after,
                                 const Accelerations<D>& a_after) -> Error {
  const double h = taken.h;
  const State<D>& before = step.at.now;
  const double x = scene_.accuracy, last = step.at.done > 0 ? step.at.last : kFirst * scene_.step;
  using Pair = typename NearPairs<D>::Pair;
  const auto gap = [&](const State<D>& state, const Pair& pair) {
    return pair_place<D>(state.bodies, state.walls, state.cell, pair).gap;
  };
  Error error;
  error.hit = step.jump;
  const auto misplace = [&](int i, int j, double overlap) {
    const double way = (1 + pair_law(scene_, after.bodies, after.walls, i, j).e_n) * overlap;
    if (way < 2 * scene_.contact_distance) return;
    const double radii = way / pair_radius(after.bodies, after.walls, i, j);
    if (radii <= x * error.misplaced) return;
    error.misplaced = radii / x;
    error.i = i;
    error.j = j;
  };
  std::vector<double> ways(after.bodies.size());
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const Body<D>&from = before.bodies[k], &to = after.bodies[k];
    ways[k] = 0.5 * h *
              std::max((from.v + to.v).norm(), to.radius * magnitude(Spin<D>(from.spin + to.spin)));
  }
  for (const ContactOutcome<D>& c : after.contacts) {
    if (c.status == ContactStatus::kTakeOff) continue;
    const auto [i, j] = std::pair(c.contact.i, c.contact.j);
    const Pair pair{i, j, c.contact.image_x, c.contact.image_y};
    const double start = gap(before, pair);
    const double way =
        (1 + 0.5 * last / h) *
            (ways[to_size(i)] + (to_size(j) < ways.size() ? ways[to_size(j)] : 0.0)) +
        x * pair_radius(after.bodies, after.walls, i, j);
    // What lasts has no velocity along the normal where the part before ended. An impact on both
    // sides, or a wall that starts, leaves one in a pair that pushed.
    if (!pushed(before.contacts, i, j) ||
        h * approach_speed(taken.closings, i, j) > kApproach * x * way) {
      error.hit = true;
      misplace(i, j, std::max(std::min(start, 0.0) - c.contact.gap, 0.0));
      continue;
    }
    error.drift = std::max(error.drift, std::abs(gap(after, pair) - start) / (x * way));
  }
  for (const Pair& pair : closings_.overlapping(after)) {
    if (find_pair(after.contacts, pair.i, pair.j) != nullptr) continue;
    misplace(pair.i, pair.j, std::min(gap(before, pair), 0.0) - gap(after, pair));
  }
  error.hit = error.hit || error.misplaced > kHit;
  if (error.hit) {
    error.drift = 0;
    return error;
  }
  if (!step.a) return error;
  const auto add = [&](double change, double way, double size) {
    error.acceleration =
        std::max(error.acceleration, 0.5 * h * h * change / (x * (way + x * size)));
  };
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const Body<D>& body = after.bodies[k];
    if (body.wall >= 0) continue;
    add(std::max((a_after.bodies[k] - step.a->bodies[k]).norm(),
                 body.radius * magnitude(Spin<D>(a_after.spins[k] - step.a->spins[k]))),
        ways[k], body.radius);
  }
  for (std::size_t w = 0; w < after.walls.size(); ++w) {
    if (after.walls[w].motion != Wall<D>::Motion::kDriven) continue;
    add((a_after.walls[w] - step.a->walls[w]).norm(),
        0.5 * h * (before.walls[w].v + after.walls[w].v).norm(), radius_);
  }
  return error;
}

/// The size of the next part, and what limits it.
template <int D>
auto AccurateStepper<D>::next_part(const Step& step) -> Part {
  const double whole = scene_.step, smallest = kSmallest * whole;
  const State<D>& now = step.at.now;
  if (is_over_()) {
    throw StepFailure(StepFailure::Kind::kCutShort, step.start, "ended within the step");
  }
  double left = whole - step.at.done;
  const double change = next_change(scene_, now.time, kEnd * whole) - now.time;
  if (change < left - kEnd * whole) left = change;  // one at the end of the step, but for rounding
  double h = std::min({step.smooth, left, longest_});
  // Rounding must not keep a wall at rest that starts now.
  const std::vector<Wall<D>> walls = walls_at(scene_.walls, now.walls, now.time + kEnd * whole);
  Accelerations<D> without_contacts;
  if (!step.a) without_contacts = free_accelerations(scene_, now, walls);
  std::vector<Closing<D>> closing =
      closings_.find(now, walls, step.a ? *step.a : without_contacts, h);
  std::string by = place(now, closing, h);
  if (by.empty()) by = h == longest_ ? "acceleration" : h == step.smooth ? step.smooth_by : "none";
  if (step.shrink < 1) {
    h *= step.shrink;
    by = step.shrunk_by;
  }
  const bool ends = h >= left * (1 - kEnd);
  if (ends) h = left;
  if (h < smallest && !ends) {
    throw StepFailure(StepFailure::Kind::kInvalidInput, step.start,
                      fmt::format("accuracy = {:g} asks for a part of {:.3g} s ({}), shorter than "
                                  "the step / 2^20: give a larger accuracy or a shorter step",
                                  scene_.accuracy, h, by));
  }
  return {h, ends, by, std::move(closing)};
}

/// Takes a part; `next` is the state after it. The reason if it failed and is to be halved, else
/// empty.
template <int D>
std::string AccurateStepper<D>::take(const Step& step, double h, State<D>& next,
                                     StepReport<D>& report) {
  const bool halves = 0.5 * h >= kSmallest * scene_.step;
  scale_impulses(next.contacts, h / step.at.last);
  part_.step = h;
  try {
    report = stepper_.advance(next);
    if (report.converged || options_.takes_unsolved()) return {};
    if (options_.on_failure == OnFailure::kStop || !halves) {
      throw StepFailure(StepFailure::Kind::kNotConverged, step.start, report.message);
    }
    return report.message;
  } catch (const StepFailure& failure) {
    const bool again = failure.kind == StepFailure::Kind::kPassage ||
                       failure.kind == StepFailure::Kind::kPlaces ||
                       (failure.kind == StepFailure::Kind::kNumerical &&
                        options_.on_failure == OnFailure::kSmallerStep);
    if (!again || !halves) throw;
    return failure.what();
  }
}

/// True if the part misses the accuracy: the next attempt is shorter.
template <int D>
bool AccurateStepper<D>::rejects(const Error& error, double h, const State<D>& next,
                                 Step& step) const {
  if (error.misplaced > kSlack) {
    ++step.at.cut.misplacing;
    step.shrink *= std::clamp(0.8 / error.misplaced, 0.1, 0.7);
    step.shrunk_by = impact(next, error.i, error.j);
    return true;
  }
  if (error.smooth() <= kSlack) return false;
  ++(error.drift > error.acceleration ? step.at.cut.drifting : step.at.cut.accelerating);
  step.smooth = h * std::max(kDrop, kAim / error.smooth());
  step.smooth_by = error.smooth_kind();
  return true;
}

/// Goes on after a part: counts, and the size that smooth motion allows for the next one.
template <int D>
void AccurateStepper<D>::go_on(const Part& taken, const Error& error, const Accelerations<D>& a,
                               Step& step) const {
  const double whole = scene_.step, x = scene_.accuracy, h = taken.h;
  step.at.done = h == whole - step.at.done ? whole : step.at.done + h;
  step.at.now.time = step.start.time + step.at.done;
  step.at.now.step = step.start.step;
  step.at.last = h;
  step.at.shortest = std::min(step.at.shortest, h);
  StepParts& cut = step.at.cut;
  if (!taken.ends && h < cut.smallest) {
    cut.smallest = h;
    cut.limited_by = taken.by;
  }
  cut.misplaced = std::max(cut.misplaced, x * error.misplaced);
  cut.misplaced_sum += x * error.misplaced;
  step.shrink = 1;
  step.a.reset();
  if (error.hit) {
    step.smooth = std::min(step.smooth, std::max(kFirst * whole, kGrowth * h));
    return;
  }
  step.a = a;
  if (error.smooth() > kAim) {
    step.smooth = h * kAim / error.smooth();
    step.smooth_by = error.smooth_kind();
  } else if (h >= 0.5 * std::min(step.smooth, whole)) {
    const double growth = std::sqrt(kAim / std::max(error.smooth(), 1e-3));
    step.smooth = std::min(whole, h * std::min(kGrowth, growth));
    step.smooth_by = growth < kGrowth && step.smooth < whole ? error.smooth_kind() : "none";
  }
}

template <int D>
StepReport<D> AccurateStepper<D>::advance(State<D>& state) {
  Step step(scene_, with_changed_population(scene_, state));
  if (scene_.has_gates()) closings_.forget();
  while (step.at.done < scene_.step) {
    step.jump = a_wall_jumps(scene_, step.at.now.time, kEnd * scene_.step);
    if (step.jump) step.a.reset();
    const Part chosen = next_part(step);
    State<D> next = step.at.now;
    StepReport<D> report;
    if (const std::string failed = take(step, chosen.h, next, report); !failed.empty()) {
      step.since.add_rejected(report);
      ++step.at.cut.failed;
      step.shrink *= 0.5;
      step.shrunk_by = "failure";
      continue;
    }
    const Accelerations<D> a = mean_accelerations(scene_, step.at.now, next, chosen.h);
    const Error error = measure(step, chosen, next, a);
    if (rejects(error, chosen.h, next, step)) {
      step.since.add_rejected(report);
      // The first part was not judged by its acceleration, and the second one against it alone. By
      // this change both may have been too long.
      const double of_last = error.acceleration * std::pow(step.at.last / chosen.h, 2);
      if (step.since.count() > 0 && step.since.count() <= 2 && of_last > kSlack) step.go_back();
      continue;
    }
    step.at.now = std::move(next);
    go_on(chosen, error, a, step);
    step.since.add(report, step.at.now.contacts);
    if (error.hit && step.at.done < scene_.step) step.set_mark();
  }
  step.sums.add(step.since);
  step.at.cut.parts = step.sums.count();
  if (!std::isfinite(step.at.cut.smallest)) {
    step.at.cut.smallest = step.at.shortest;
    step.at.cut.limited_by = "none";
  }
  const std::vector<ContactOutcome<D>> of_last_part = step.at.now.contacts;
  StepReport<D> report = step.sums.finish(step.start, scene_.step, step.at.now);
  for (ContactOutcome<D>& c : step.at.now.contacts) {
    if (find_pair(of_last_part, c.contact.i, c.contact.j) == nullptr) {
      c.status = ContactStatus::kTakeOff;
    }
  }
  report.cut = std::move(step.at.cut);
  state = std::move(step.at.now);
  return report;
}

template class AccurateStepper<2>;
template class AccurateStepper<3>;

}  // namespace bipot
