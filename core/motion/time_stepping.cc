#include "core/motion/time_stepping.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/release.h"
#include "core/base/stopwatch.h"
#include "core/motion/midpoint.h"
#include "core/motion/outside_changes.h"
#include "core/motion/population.h"
#include "core/motion/projection.h"
#include "core/motion/update_bodies.h"
#include "core/motion/warm_start.h"
#include "core/problem/delassus.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

/// Accumulated work of the state after the step, and the balances of energy and momentum.
template <int D>
void close_ledger(const Scene<D>& scene, const State<D>& before, const StepOutcome<D>& outcome,
                  State<D>& next, StepReport<D>& report) {
  const Vec<D> gravity = gravity_at(scene, next.time);
  next.wall_work = before.wall_work + outcome.wall_work;
  next.friction_loss = before.friction_loss + outcome.friction_loss;
  next.shock_loss = before.shock_loss + outcome.shock_loss;
  const StateSums<D> now = state_sums(next, gravity),
                     then = state_sums(before, gravity_at(scene, before.time));
  report.energy = {.kinetic = now.kinetic,
                   .potential = now.potential,
                   .wall_work = next.wall_work,
                   .friction_loss = next.friction_loss,
                   .shock_loss = next.shock_loss,
                   .passed = energy_passed(next)};
  report.energy.imbalance = report.energy.kinetic + report.energy.potential - then.kinetic -
                            then.potential - outcome.wall_work + outcome.friction_loss +
                            outcome.shock_loss;
  if (!std::isfinite(report.energy.kinetic + report.energy.potential)) {
    throw StepFailure(StepFailure::Kind::kNumerical, before, "the energy is not finite");
  }
  report.momentum = now.momentum;
  report.momentum_imbalance = report.momentum - then.momentum - outcome.external;
}

}  // namespace

template <int D>
TimeStepper<D>::TimeStepper(const Scene<D>& scene, StepSolver solver, bool explicit_delassus,
                            int threads)
    : scene_(scene),
      solver_(std::move(solver)),
      explicit_delassus_(explicit_delassus),
      threads_(threads) {}

StepFailure::StepFailure(Kind k, int steps_before, double time_before, const std::string& why)
    : StepFailure(k,
                  fmt::format("step {} at t = {:.9g} s: {}", steps_before + 1, time_before, why)) {}

template <int D>
ContactProblem step_problem(const Scene<D>& scene, const State<D>& state, bool explicit_delassus) {
  if (scene.has_gates()) {
    const State<D> start = with_changed_population(scene, state);
    return assemble_step(scene, make_midpoint(scene, start), explicit_delassus).problem;
  }
  return assemble_step(scene, make_midpoint(scene, state), explicit_delassus).problem;
}

template <int D>
Vector take_solution(StepSolution solution, bool usable, const State<D>& before,
                     StepReport<D>& report) {
  using Kind = StepFailure::Kind;
  if (solution.refused) throw StepFailure(Kind::kInvalidInput, before, solution.message);
  if (solution.cut_short) throw StepFailure(Kind::kCutShort, before, solution.message);
  if (solution.failed || !usable) {
    throw StepFailure(
        Kind::kNumerical, before,
        solution.message.empty() ? "the solver returned no finite impulse" : solution.message);
  }
  report.converged = solution.converged;
  report.message = std::move(solution.message);
  report.iterations = solution.iterations;
  report.error = solution.error;
  return std::move(solution.s);
}
template Vector take_solution(StepSolution, bool, const State<2>&, StepReport<2>&);
template Vector take_solution(StepSolution, bool, const State<3>&, StepReport<3>&);

/// The impulses of the step, in the problem's variables.
template <int D>
Vector TimeStepper<D>::solve_contacts(const State<D>& state, std::span<const Contact<D>> contacts,
                                      StepReport<D>& report) {
  const ContactProblem& p = assembled_.problem;
  Vector s0 = scene_.solver.warm_start ? warm_start<D>(state.contacts, contacts, p) : Vector();
  StepSolution solution = solver_(p, std::move(s0));
  const bool usable = solution.s.size() == p.num_rows() && solution.s.allFinite();
  return take_solution(std::move(solution), usable, state, report);
}

/// What lifts the bodies out of each other is what their shocks took too much: it is booked there.
template <int D>
void TimeStepper<D>::take_out_overlaps(State<D>& next, StepOutcome<D>& outcome,
                                       StepReport<D>& report) {
  const Vec<D> gravity = gravity_at(scene_, next.time);
  const double before = potential_energy(next, gravity);
  const Projection done = project_overlaps(scene_, solver_, explicit_delassus_, threads_, next);
  report.iterations += done.iterations;
  if (!done.solved) {
    report.converged = false;
    report.message = done.message;
  }
  outcome.wall_work += done.wall_work;
  outcome.shock_loss -= potential_energy(next, gravity) - before - done.wall_work;
}

template <int D>
StepReport<D> TimeStepper<D>::advance(State<D>& state) {
  StepReport<D> report;
  Stopwatch watch;
  std::optional<State<D>> changed;
  if (scene_.has_gates()) {
    changed = state;
    if (change_population(scene_, *changed)) kept_ = {};
  }
  const State<D>& start = changed ? *changed : state;
  Midpoint<D> mid = make_midpoint(scene_, start, threads_, &kept_);
  report.detection_seconds = watch.lap();
  assembled_ = assemble_step(scene_, mid, explicit_delassus_, threads_);
  report.assembly_seconds = watch.lap();
  release(mid.bodies);  // a tenth of a run's memory where the solver takes the most
  const Vector s = solve_contacts(start, mid.contacts, report);
  report.solve_seconds = watch.lap();

  const ContactProblem& p = assembled_.problem;
  const Vector v = p.num_dofs() > 0 ? body_velocities(p, s) : Vector();
  place_bodies(scene_, start, mid);
  State<D> next = update_bodies(mid, assembled_.dofs, v, scene_.step);
  next.step = start.step + 1;
  next.time = time_after_step(start, scene_.step);
  StepOutcome<D> outcome =
      step_outcome<D>(scene_, mid, next.bodies, assembled_, s, v, next.walls, next.cell);
  const OutsideChanges<D> changes =
      outside_changes(scene_, start, mid.walls, mid.gravity, next, next.time);
  outcome.wall_work += changes.work;
  outcome.external += changes.impulse;
  if (scene_.project_overlaps) take_out_overlaps(next, outcome, report);
  next.population = start.population;
  close_ledger(scene_, start, outcome, next, report);
  next.contacts = std::move(outcome.contacts);

  report.step = next.step;
  report.time = next.time;
  report.contacts = static_cast<int>(mid.contacts.size());
  report.active = outcome.active;
  for (const Contact<D>& c : mid.contacts)
    report.penetration = std::max(report.penetration, -c.gap);
  state = std::move(next);
  return report;
}

template class TimeStepper<2>;
template class TimeStepper<3>;
template ContactProblem step_problem(const Scene<2>&, const State<2>&, bool);
template ContactProblem step_problem(const Scene<3>&, const State<3>&, bool);

}  // namespace bipot
