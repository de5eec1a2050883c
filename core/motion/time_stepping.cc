#include "core/motion/time_stepping.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "core/base/number_buffer.h"
#include "core/base/release.h"
#include "core/base/stopwatch.h"
#include "core/motion/impact_law.h"
#include "core/motion/joint_rows.h"
#include "core/motion/midpoint.h"
#include "core/motion/neighbours.h"
#include "core/motion/outside_changes.h"
#include "core/motion/passage.h"
#include "core/motion/population.h"
#include "core/motion/projection.h"
#include "core/motion/step_outcome.h"
#include "core/motion/warm_start.h"
#include "core/problem/delassus.h"
#include "core/problem/equality_rows.h"
#include "core/scene/contact_detection.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

using Impact = ContactLaw::Impact;

/// The impulses of a step, in the problem's variables; the solver's account of them goes into the
/// report. Throws StepFailure where it refused, was cut short or failed, and where they are not
/// `usable`: finite and of the problem's size.
template <int D>
Vector take_solution(StepSolution solution, bool usable, const State<D>& before,
                     StepReport<D>& report) {
  using Kind = StepFailure::Kind;
  if (solution.refused) throw StepFailure(Kind::kInvalidInput, before, solution.message);
  if (solution.cut_short) throw StepFailure(Kind::kCutShort, before, solution.message);
  if (solution.failed || !usable) {
    throw StepFailure(
        solution.unsolvable ? Kind::kUnsolvable : Kind::kNumerical, before,
        solution.message.empty() ? "the solver returned no finite impulse" : solution.message);
  }
  report.converged = solution.converged;
  report.unsolvable = solution.unsolvable;
  report.message = std::move(solution.message);
  report.iterations = solution.iterations;
  report.error = solution.error;
  return std::move(solution.s);
}

}  // namespace

StepFailure::StepFailure(Kind k, int steps_before, double time_before, const std::string& why)
    : StepFailure(k,
                  fmt::format("step {} at t = {:.9g} s: {}", steps_before + 1, time_before, why)) {}

template <int D>
ContactProblem step_problem(const Scene<D>& scene, const State<D>& state) {
  if (scene.has_gates()) {
    Scene<D> open = scene;
    open.outlets.clear();
    open.inlets.clear();
    return step_problem(open, with_changed_population(scene, state));
  }
  const Midpoint<D> mid = make_midpoint(scene, state);
  if (scene.impact == Impact::kNewton) return assemble_step(scene, mid).problem;
  AssembledStep step = assemble_step(with_step_laws(scene), mid);
  if (scene.impact == Impact::kPoisson) return compression_problem(state, mid, step);
  add_mean_restitution(scene, state, mid, step);
  return step.problem;
}

template <int D>
struct TimeStepper<D>::Inside {
  const Scene<D>& scene;
  StepSolver solver;
  int threads = 1;
  Neighbours<D>* neighbours = nullptr;  // none: the state lies on this process alone
  bool refuse_passages = false;
  double unnamed_overlap = 0;  // name_overlaps_beyond()
  KeptContacts<D> kept;
  AssembledStep assembled;              // without neighbours
  std::optional<Scene<D>> step_laws;    // with_step_laws(), but for Newton's law
  std::optional<ContactProblem> phase;  // of Poisson's law: solved last

  const ContactProblem& problem() const {
    return neighbours != nullptr ? neighbours->problem() : assembled.problem;
  }
  const Scene<D>& laws() const { return step_laws ? *step_laws : scene; }
  bool counts_walls() const { return neighbours == nullptr || neighbours->counts_walls(); }

  Midpoint<D> midpoint(const State<D>& start);
  void assemble(const State<D>& start, const Midpoint<D>& mid);
  void refuse_driven_pins(const State<D>& start, const Midpoint<D>& mid) const;
  Vector start_of(const State<D>& state, const Midpoint<D>& mid) const;
  Vector solve_contacts(const State<D>& state, const Midpoint<D>& mid, StepReport<D>& report);
  Vector solve_phase(const State<D>& state, Vector s0, StepReport<D>& report);
  Vector solve_phases(const State<D>& state, const Midpoint<D>& mid, StepReport<D>& report);
  State<D> move(const State<D>& start, Midpoint<D>& mid, const Vector& s, Vector& v);
  void check_motion(const State<D>& start, const State<D>& next, StepReport<D>& report);
  void measure_overlaps(const State<D>& start, const Midpoint<D>& mid,
                        const std::vector<Body<D>>& bodies, StepReport<D>& report);
  std::string first_of_all(double key, const std::string& text);
  void take_out_overlaps(State<D>& next, StepOutcome<D>& outcome, StepReport<D>& report);
  void close_ledger(const State<D>& before, const Midpoint<D>& mid, StepOutcome<D>& outcome,
                    State<D>& next, StepReport<D>& report);
  StepReport<D> advance(State<D>& state);
};

template <int D>
Midpoint<D> TimeStepper<D>::Inside::midpoint(const State<D>& start) {
  if (neighbours != nullptr) return neighbours->midpoint();
  try {
    return make_midpoint(scene, start, threads, &kept);
  } catch (const std::invalid_argument& e) {
    throw StepFailure(StepFailure::Kind::kPlaces, start, e.what());
  }
}

template <int D>
void TimeStepper<D>::Inside::assemble(const State<D>& start, const Midpoint<D>& mid) {
  if (scene.impact != Impact::kNewton && !step_laws) step_laws = with_step_laws(scene);
  try {
    assembled = assemble_step(laws(), mid, threads);
  } catch (const std::invalid_argument& e) {  // pins that couple too many bodies
    throw StepFailure(StepFailure::Kind::kInvalidInput, start, e.what());
  }
  refuse_driven_pins(start, mid);
  if (scene.impact == Impact::kFremond) add_mean_restitution(scene, start, mid, assembled);
}

/// No impulse stops a wall that moves into a body where pins leave it no motion.
template <int D>
void TimeStepper<D>::Inside::refuse_driven_pins(const State<D>& start,
                                                const Midpoint<D>& mid) const {
  constexpr double kAlong = 1e-9;
  if (!assembled.problem.equality) return;
  for (const int k : assembled.problem.equality->blocked) {
    if (to_size(k) >= mid.contacts.size()) break;  // ropes
    const Contact<D>& c = mid.contacts[to_size(k)];
    const int w = wall_of(mid.bodies, c.j);
    if (w < 0) continue;
    const Wall<D>& wall = mid.walls[to_size(w)];
    if (c.n.dot(wall.v) <= kAlong * wall.v.norm()) continue;
    throw StepFailure(
        StepFailure::Kind::kPlaces, start,
        fmt::format("wall '{}' moves into {} {}, which pins hold there",
                    scene.walls[to_size(w)].name, kBodyName<D>, body_number(start, c.i)));
  }
}

/// From where the solver starts, in the problem's variables; empty: from nowhere.
template <int D>
Vector TimeStepper<D>::Inside::start_of(const State<D>& state, const Midpoint<D>& mid) const {
  const ContactProblem& p = problem();
  std::span<const Contact<D>> contacts = mid.contacts;
  Vector s0;
  if (scene.solver.warm_start) {
    const int bodies = static_cast<int>(mid.disk_v_free.size());
    std::vector<const Wall<D>*> walls;
    for (const Contact<D>& c : contacts) {
      walls.push_back(c.j < bodies ? nullptr : &scene.walls[to_size(c.j - bodies)]);
    }
    std::vector<Contact<D>> numbered;
    if (neighbours != nullptr) {
      numbered.assign(contacts.begin(), contacts.end());
      for (Contact<D>& c : numbered) neighbours->number(c);
      contacts = numbered;
    }
    s0 = warm_start<D>(state.contacts, contacts, walls, p);
  }
  if (s0.size() > 0 && assembled.pull.size() > 0) s0 += assembled.pull;
  return s0;
}

/// The impulses of the step, in the problem's variables.
template <int D>
Vector TimeStepper<D>::Inside::solve_contacts(const State<D>& state, const Midpoint<D>& mid,
                                              StepReport<D>& report) {
  const ContactProblem& p = problem();
  Vector s0 = start_of(state, mid);
  StepSolution solution = neighbours != nullptr ? neighbours->solve(s0) : solver(p, std::move(s0));
  bool usable = solution.s.size() == p.num_rows() && solution.s.allFinite();
  if (neighbours != nullptr)
    usable = neighbours->all(usable || solution.refused || solution.cut_short);
  return take_solution(std::move(solution), usable, state, report);
}

template <int D>
Vector TimeStepper<D>::Inside::solve_phase(const State<D>& state, Vector s0,
                                           StepReport<D>& report) {
  StepSolution solution = solver(*phase, std::move(s0));
  const bool usable = solution.s.size() == phase->num_rows() && solution.s.allFinite();
  return take_solution(std::move(solution), usable, state, report);
}

/// The impulses of both phases of Poisson's law. The report has the larger error, and the message
/// of the first phase that was not solved.
template <int D>
Vector TimeStepper<D>::Inside::solve_phases(const State<D>& state, const Midpoint<D>& mid,
                                            StepReport<D>& report) {
  const ContactProblem& p = assembled.problem;
  StepReport<D> first;
  Vector compression = Vector::Zero(p.num_rows());
  const bool two = has_compression(assembled, scene.solver.tol);
  if (two) {
    phase = compression_problem(state, mid, assembled);
    compression = solve_phase(state, Vector(), first);
  }
  const Vector returned = returned_impulses(scene, state, mid, p, compression);
  phase = expansion_problem(p, compression, returned);
  Vector s0 = start_of(state, mid);
  if (s0.size() > 0) s0.conservativeResizeLike(Vector::Zero(phase->num_rows()));
  const Vector expansion = solve_phase(state, std::move(s0), report);
  report.iterations += first.iterations;
  if (two && !(first.error.guarded() <= report.error.guarded())) report.error = first.error;
  if (!first.converged) {
    report.converged = false;
    report.unsolvable = report.unsolvable || first.unsolvable;
    report.message = "compression: " + first.message;
  }
  return impulses_of_phases(p, compression, returned, expansion);
}

/// The state after the step, but for its time, its books and its contacts; v as of
/// Neighbours::move().
template <int D>
State<D> TimeStepper<D>::Inside::move(const State<D>& start, Midpoint<D>& mid, const Vector& s,
                                      Vector& v) {
  if (neighbours != nullptr) return neighbours->move(mid, v);
  const ContactProblem& p = assembled.problem;
  if (p.num_dofs() > 0 || p.equality) v = body_velocities(p, s);
  place_bodies(scene, start, mid);
  return update_bodies(mid, assembled.dofs, v, scene.step);
}

/// The text of the process with the smallest key; infinite: it has none.
template <int D>
std::string TimeStepper<D>::Inside::first_of_all(double key, const std::string& text) {
  if (neighbours == nullptr) return text;
  double first[1] = {-key};
  neighbours->largest(first);
  return neighbours->first_text(-first[0] == key && std::isfinite(key) ? text : std::string());
}

/// How far bodies moved, and what went through what. Only where something is fast are pairs looked
/// at.
template <int D>
void TimeStepper<D>::Inside::check_motion(const State<D>& start, const State<D>& next,
                                          StepReport<D>& report) {
  const double h = scene.step;
  StepTravel travel = step_travel(start, next, h);
  if (neighbours != nullptr) {
    double most[] = {travel.radii, travel.way, -travel.least};
    neighbours->largest(most);
    travel.radii = most[0];
    travel.way = most[1];
    travel.least = -most[2];
  }
  report.travel = travel.radii;
  if (!travel.may_pass()) return;
  const auto number = [&](int k) {
    return neighbours != nullptr ? neighbours->body_number(k) : body_number(start, k);
  };
  std::vector<BodyPath<D>> ways = paths_of<D>(start, next, h, travel, number);
  if (neighbours != nullptr) {
    std::vector<BodyPath<D>> fast;
    std::copy_if(ways.begin(), ways.end(), std::back_inserter(fast),
                 [](const BodyPath<D>& way) { return way.fast; });
    std::set<int> here;
    for (const BodyPath<D>& way : fast) here.insert(way.number);
    for (const BodyPath<D>& way : unpacked<D>(neighbours->gather(packed(fast)))) {
      if (!here.contains(way.number)) ways.push_back(way);
    }
  }
  const std::vector<Passage> passages = find_passages(start, next, h, ways);
  double count[1] = {static_cast<double>(passages.size())};
  if (neighbours != nullptr) neighbours->sum(count);
  report.passages = static_cast<int>(count[0]);
  if (report.passages == 0) return;
  report.passage = passages.empty() ? first_of_all(kInfinity, {})
                                    : first_of_all(1e8 * passages[0].i + passages[0].j,
                                                   passage_text(scene, passages[0]));
  if (!refuse_passages) return;
  throw StepFailure(StepFailure::Kind::kPassage, start, report.passage);
}

/// The deepest overlap at mid-step, by itself and over the smaller radius. `bodies`: those that the
/// contacts name, for their radii.
template <int D>
void TimeStepper<D>::Inside::measure_overlaps(const State<D>& start, const Midpoint<D>& mid,
                                              const std::vector<Body<D>>& bodies,
                                              StepReport<D>& report) {
  const Contact<D>* worst = nullptr;
  for (const Contact<D>& c : mid.contacts) {
    if (!(c.gap < 0)) continue;
    report.penetration = std::max(report.penetration, -c.gap);
    const double radius = pair_radius(bodies, mid.walls, c.i, c.j);
    if (-c.gap <= report.overlap * radius) continue;
    report.overlap = -c.gap / radius;
    worst = &c;
  }
  const double here = report.overlap;
  if (neighbours != nullptr) {
    double most[] = {report.penetration, report.overlap};
    neighbours->largest(most);
    report.penetration = most[0];
    report.overlap = most[1];
  }
  if (!(report.overlap > unnamed_overlap)) return;
  if (worst == nullptr || here < report.overlap) {
    report.overlap_pair = first_of_all(kInfinity, {});
    return;
  }
  Contact<D> pair = *worst;
  if (neighbours != nullptr) neighbours->number(pair);
  const auto number = [&](int k) { return neighbours != nullptr ? k : body_number(start, k); };
  const std::size_t j = to_size(worst->j);
  report.overlap_pair = first_of_all(
      1e8 * pair.i + pair.j,
      j < bodies.size()
          ? fmt::format("{0} {1} and {0} {2}", kBodyName<D>, number(pair.i), number(pair.j))
          : fmt::format("{} {} and wall '{}'", kBodyName<D>, number(pair.i),
                        scene.walls[j - bodies.size()].name));
}

/// What lifts the bodies out of each other is what their shocks took too much: it is booked there.
template <int D>
void TimeStepper<D>::Inside::take_out_overlaps(State<D>& next, StepOutcome<D>& outcome,
                                               StepReport<D>& report) {
  const Vec<D> gravity = gravity_at(scene, next.time);
  const double before = potential_energy(next, gravity);
  const Projection done = project_overlaps(scene, solver, threads, next);
  report.iterations += done.iterations;
  if (!done.solved) {
    report.converged = false;
    report.message = done.message;
  }
  outcome.wall_work += done.wall_work;
  outcome.shock_loss -= potential_energy(next, gravity) - before - done.wall_work;
}

/// Accumulated work of the state after the step, the balances of energy and momentum, and all else
/// that is summed over the processes.
template <int D>
void TimeStepper<D>::Inside::close_ledger(const State<D>& before, const Midpoint<D>& mid,
                                          StepOutcome<D>& outcome, State<D>& next,
                                          StepReport<D>& report) {
  StateSums<D> now = state_sums(next, gravity_at(scene, next.time), counts_walls()),
               then = state_sums(before, gravity_at(scene, before.time), counts_walls());
  const std::size_t bodies = neighbours != nullptr ? mid.bodies.size() : next.bodies.size();
  report.force_energy =
      force_energy<D>(mid.gravity, mid.walls, mid.cell, scene.step, outcome.contacts, bodies);
  auto contacts = static_cast<double>(mid.contacts.size());
  auto active = static_cast<double>(outcome.active);
  if (neighbours != nullptr) {
    const auto pass = [&](const auto& each) {  // all in one reduction
      each(outcome.wall_work, outcome.friction_loss, outcome.shock_loss, contacts, active,
           report.force_energy, now.kinetic, now.potential, then.kinetic, then.potential,
           outcome.external, now.momentum, then.momentum);
    };
    Buffer numbers;
    pass([&](const auto&... values) { append(numbers, values...); });
    neighbours->sum(numbers);
    BufferReader reader(numbers);
    pass([&](auto&... values) { reader.take(values...); });
  }
  report.contacts = static_cast<int>(contacts);
  report.active = static_cast<int>(active);

  next.wall_work = before.wall_work + outcome.wall_work;
  next.friction_loss = before.friction_loss + outcome.friction_loss;
  next.shock_loss = before.shock_loss + outcome.shock_loss;
  next.cohesion_loss = before.cohesion_loss + outcome.cohesion_loss;
  report.energy = {.kinetic = now.kinetic,
                   .potential = now.potential,
                   .wall_work = next.wall_work,
                   .friction_loss = next.friction_loss,
                   .shock_loss = next.shock_loss,
                   .cohesion_loss = next.cohesion_loss,
                   .passed = passed(next).energy};
  report.energy.imbalance = report.energy.kinetic + report.energy.potential - then.kinetic -
                            then.potential - outcome.wall_work + outcome.friction_loss +
                            outcome.shock_loss + outcome.cohesion_loss;
  if (!std::isfinite(report.energy.kinetic + report.energy.potential)) {
    throw StepFailure(StepFailure::Kind::kNumerical, before, "the energy is not finite");
  }
  report.joint_loss = outcome.joint_loss;
  report.from_rest = outcome.from_rest;
  report.momentum = now.momentum;
  report.momentum_imbalance = report.momentum - then.momentum - outcome.external;
}

template <int D>
StepReport<D> TimeStepper<D>::Inside::advance(State<D>& state) {
  StepReport<D> report;
  Stopwatch watch;
  std::optional<State<D>> changed;
  if (scene.has_gates()) {
    changed = state;
    if (change_population(scene, *changed)) kept = {};
  }
  const State<D>& start = changed ? *changed : state;
  Midpoint<D> mid = midpoint(start);
  report.detection_seconds = watch.lap();
  if (neighbours == nullptr) assemble(start, mid);
  const AssembledStep& step = neighbours != nullptr ? neighbours->assemble(mid) : assembled;
  report.assembly_seconds = watch.lap();
  // A tenth of a run's memory where the solver takes the most; neighbours name bodies of mid-step.
  if (neighbours == nullptr) release(mid.bodies);
  const Vector s = scene.impact == Impact::kPoisson ? solve_phases(start, mid, report)
                                                    : solve_contacts(start, mid, report);
  report.solve_seconds = watch.lap();

  Vector v;
  State<D> next = move(start, mid, s, v);
  next.step = start.step + 1;
  next.time = time_after_step(start, scene.step);
  check_motion(start, next, report);
  measure_overlaps(start, mid, neighbours != nullptr ? mid.bodies : next.bodies, report);
  StepOutcome<D> outcome =
      step_outcome<D>(laws(), mid, neighbours != nullptr ? mid.bodies : next.bodies, problem(),
                      step, s, v, next, counts_walls());
  if (!counts_walls()) mid.walls.clear();
  const OutsideChanges<D> changes =
      outside_changes<D>(scene, start, mid.walls, mid.gravity, mid.disk_v_free, next);
  outcome.wall_work += changes.work;
  outcome.external += changes.impulse;
  if (scene.project_overlaps) take_out_overlaps(next, outcome, report);
  next.population = start.population;
  close_ledger(start, mid, outcome, next, report);
  if (neighbours != nullptr) {
    for (ContactOutcome<D>& c : outcome.contacts) neighbours->number(c.contact);
  }
  next.contacts = std::move(outcome.contacts);

  report.step = next.step;
  report.time = next.time;
  state = std::move(next);
  if (neighbours != nullptr) neighbours->settle();
  return report;
}

template <int D>
TimeStepper<D>::TimeStepper(const Scene<D>& scene, StepSolver solver, int threads)
    : inside_(new Inside{.scene = scene, .solver = std::move(solver), .threads = threads}) {}

template <int D>
TimeStepper<D>::TimeStepper(const Scene<D>& scene, Neighbours<D>& neighbours)
    : inside_(new Inside{.scene = scene, .neighbours = &neighbours}) {}

template <int D>
TimeStepper<D>::~TimeStepper() = default;
template <int D>
TimeStepper<D>::TimeStepper(TimeStepper&&) noexcept = default;

template <int D>
StepReport<D> TimeStepper<D>::advance(State<D>& state) {
  return inside_->advance(state);
}

template <int D>
void TimeStepper<D>::name_overlaps_beyond(double overlap) {
  inside_->unnamed_overlap = overlap;
}

template <int D>
void TimeStepper<D>::refuse_passages() {
  inside_->refuse_passages = true;
}

template <int D>
const ContactProblem& TimeStepper<D>::problem() const {
  return inside_->phase ? *inside_->phase : inside_->problem();
}

template class TimeStepper<2>;
template class TimeStepper<3>;
template ContactProblem step_problem(const Scene<2>&, const State<2>&);
template ContactProblem step_problem(const Scene<3>&, const State<3>&);

}  // namespace bipot
