#include "solvers/simulation/domain_stepper.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/release.h"
#include "core/base/stopwatch.h"
#include "core/motion/outside_changes.h"
#include "core/motion/step_outcome.h"
#include "core/motion/update_bodies.h"
#include "core/motion/warm_start.h"
#include "core/problem/delassus.h"
#include "solvers/parallel/whole_problem.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

/// New cells are not worth their messages until the imbalance has grown by this factor since the last.
constexpr double kWorseThanAfterCut = 1.1;

/// Numbers of different meaning that are added up over all processes in one reduction.
class SumList {
 public:
  template <class... Numbers>
  void add(Numbers&... numbers) {
    (values_.push_back(&numbers), ...);
  }
  template <int D>
  void add(Eigen::Matrix<double, D, 1>& x) {
    for (int k = 0; k < D; ++k) values_.push_back(&x[k]);
  }
  void sum(ProcessGroup& group) {
    std::vector<double> numbers;
    for (const double* x : values_) numbers.push_back(*x);
    group.sum(numbers);
    for (std::size_t k = 0; k < numbers.size(); ++k) *values_[k] = numbers[k];
  }

 private:
  std::vector<double*> values_;
};

}  // namespace

template <int D>
std::string needs_whole_state(const Scene<D>& scene) {
  if (scene.model == Model::kSpringDashpot) return "the model dem";
  if (!scene.clusters.empty()) return "the scene has clusters";
  if (scene.has_gates()) return "the scene has inlets or outlets";
  if (scene.cell.periodic()) return "the scene is periodic";
  if (scene.observables) return "the scene measures observables";
  if (scene.travel > 0) return "the scene cuts its steps by travel";
  if (scene.predict_gaps) return "the scene predicts gaps";
  if (scene.project_overlaps) return "the scene projects overlaps";
  return {};
}

DomainCounts largest_counts(const DomainCounts& mine, ProcessGroup& group) {
  DomainCounts all = mine;
  std::int64_t migrated[1] = {mine.migrated};
  group.sum(migrated);
  all.migrated = migrated[0];
  std::vector<double> numbers = {
      static_cast<double>(mine.most_bodies), static_cast<double>(mine.most_ghosts),
      static_cast<double>(mine.most_contacts), static_cast<double>(mine.most_halo)};
  Traffic* const traffics[] = {&all.detection, &all.solve, &all.migration, &all.gathering};
  for (const Traffic* t : traffics) {
    for (const std::int64_t n : {t->messages, t->bytes, t->reductions, t->reduced_bytes}) {
      numbers.push_back(static_cast<double>(n));
    }
  }
  group.largest(numbers);
  auto next = numbers.begin();
  for (int* n : {&all.most_bodies, &all.most_ghosts, &all.most_contacts, &all.most_halo}) {
    *n = static_cast<int>(*next++);
  }
  for (Traffic* t : traffics) {
    for (std::int64_t* n : {&t->messages, &t->bytes, &t->reductions, &t->reduced_bytes}) {
      *n = static_cast<std::int64_t>(*next++);
    }
  }
  return all;
}

/// One step between detection and ledger.
template <int D>
struct DomainStepper<D>::Step {
  LocalBodies<D> local;
  Midpoint<D> mid;  // of the local bodies, with the own contacts
  LocalContacts<D> contacts;
  PieceResult solved;
  StepOutcome<D> outcome;
};

template <int D>
DomainStepper<D>::DomainStepper(const Scene<D>& scene, ProcessGroup& group, Solver solver,
                                const DomainOptions& options)
    : scene_(scene), group_(group), solver_(std::move(solver)), options_(options) {}

template <int D>
DomainState<D> DomainStepper<D>::begin(const State<D>& whole) {
  cells_ = cut_cells(whole, group_.size());
  // Where no contacts were known, the first step's may ask for other cells at once.
  after_cut_ = whole.contacts.empty() ? 1 : 0;
  return cut_state(whole, cells_, group_.rank());
}

template <int D>
void DomainStepper<D>::detect(const DomainState<D>& state, Step& step) {
  step.local = with_ghosts(scene_, state, group_);
  step.mid = free_midpoint(scene_, step.local.state);
  release(step.local.state.bodies);  // mid-step has them
  step.contacts = find_local_contacts(scene_, step.local, step.mid, state.bodies, group_);
  const auto most = [](int& most_of, std::size_t here) {
    most_of = std::max(most_of, static_cast<int>(here));
  };
  most(counts_.most_bodies, step.local.own.size());
  most(counts_.most_ghosts, step.local.numbers.size() - step.local.own.size());
  most(counts_.most_contacts, step.contacts.own.size());
  most(counts_.most_halo, step.contacts.halo.size());
}

/// The impulses of the own contacts.
template <int D>
Vector DomainStepper<D>::solve(const DomainState<D>& state, Step& step, DomainReport<D>& out) {
  Vector s0;
  if (scene_.solver.warm_start) {
    std::vector<Contact<D>> numbered = step.contacts.own;
    const int here = static_cast<int>(step.local.numbers.size());
    for (Contact<D>& c : numbered) {
      c.i = step.local.numbers[to_size(c.i)];
      c.j = c.j < here ? step.local.numbers[to_size(c.j)] : state.bodies + c.j - here;
    }
    s0 = warm_start<D>(state.here.contacts, numbered, last_->piece.own);
  }
  step.solved = solver_(last_->piece, s0);
  StepSolution solution = to_step_solution(step.solved.result);
  const bool here = !solution.failed && solution.s.size() == last_->piece.own.num_rows() &&
                    solution.s.allFinite();
  const bool usable = !group_.any(!here && !solution.refused && !solution.cut_short);
  return take_solution(std::move(solution), usable, state.here, out.report);
}

/// The own bodies and the walls after the step, and what the own contacts did; the velocities of
/// bodies that own contacts push come from sums over all of their contacts, own ones or not.
template <int D>
State<D> DomainStepper<D>::move(const DomainState<D>& state, Step& step) {
  const ProblemPiece& piece = last_->piece;
  const Vector bodies = piece.with_halo.num_contacts() > 0
                            ? body_velocities(piece.with_halo, step.solved.with_halo)
                            : Vector();
  Midpoint<D> own;
  own.walls = step.mid.walls;
  own.wall_v_free = step.mid.wall_v_free;
  DofMap dofs;
  dofs.per_disk = last_->with_halo.per_disk;
  for (const int k : step.local.own) {
    own.bodies.push_back(step.mid.bodies[to_size(k)]);
    own.disk_v_free.push_back(step.mid.disk_v_free[to_size(k)]);
    dofs.disk.push_back(last_->with_halo.disk[to_size(k)]);
  }
  dofs.wall.assign(own.walls.size(), -1);
  const std::size_t driven = last_->wall.size();
  Vector v(bodies.size() + static_cast<Eigen::Index>(driven));
  v.head(bodies.size()) = bodies;
  Vector v_own(piece.own.num_dofs());
  for (Eigen::Index row = 0; row < v_own.size(); ++row) {
    const int at = piece.dof_with_halo[to_size(row)];
    if (at >= 0) v_own[row] = bodies[at];
  }
  for (std::size_t k = 0; k < driven; ++k) {
    const std::size_t w = to_size(last_->wall[k]);
    const double speed = step.mid.wall_v_free[w] +
                         piece.everywhere_inverse_mass[k] * step.solved.everywhere_momentum[k];
    dofs.wall[w] = static_cast<int>(bodies.size() + static_cast<Eigen::Index>(k));
    v[dofs.wall[w]] = speed;
    if (piece.everywhere_own_dof[k] >= 0) v_own[piece.everywhere_own_dof[k]] = speed;
  }
  State<D> next = update_bodies(own, dofs, v, scene_.step);
  next.step = state.here.step + 1;
  next.time = time_after_step(state.here, scene_.step);

  exchange(last_->own.problem, last_->piece.own);
  step.mid.contacts = std::move(step.contacts.own);
  step.outcome = contact_outcomes<D>(scene_, step.mid, step.mid.bodies, last_->own,
                                     step.solved.result.s, v_own);
  exchange(last_->own.problem, last_->piece.own);
  return next;
}

/// As TimeStepper's, with all sums in one reduction. Walls are the first process's to count.
template <int D>
void DomainStepper<D>::close_ledger(const State<D>& before, Step& step, State<D>& next,
                                    DomainReport<D>& out) {
  StepReport<D>& report = out.report;
  StepOutcome<D>& outcome = step.outcome;
  const bool counts_walls = group_.rank() == 0;
  const std::vector<Wall<D>> none;
  const auto& walls_in_step = counts_walls ? step.mid.walls : none;
  for (const Body<D>& d : next.bodies) outcome.external += scene_.step * d.mass * step.mid.gravity;
  add_driving_forces<D>(scene_.step, walls_in_step, next.walls, outcome);
  const OutsideChanges<D> changes =
      outside_changes(scene_, before, walls_in_step, step.mid.gravity, next, next.time);
  outcome.wall_work += changes.work;
  outcome.external += changes.impulse;
  StateSums<D> now, then;
  add_to_sums<D>(next.bodies, counts_walls ? next.walls : none, gravity_at(scene_, next.time), now);
  add_to_sums<D>(before.bodies, counts_walls ? before.walls : none, gravity_at(scene_, before.time),
                 then);
  double active = outcome.active;
  double penetration[1] = {0};
  for (const ContactOutcome<D>& c : outcome.contacts) {
    penetration[0] = std::max(penetration[0], -c.contact.gap);
    const bool at_wall = to_size(c.contact.j) >= step.mid.bodies.size();
    if (at_wall) out.wall_pushes += std::hypot(c.s_n, magnitude(c.s_t));
  }
  SumList sums;
  sums.add(outcome.wall_work, outcome.friction_loss, outcome.shock_loss, active, out.wall_pushes);
  sums.add(now.kinetic, now.potential, then.kinetic, then.potential);
  sums.add(outcome.external);
  sums.add(now.momentum);
  sums.add(then.momentum);
  sums.sum(group_);
  group_.largest(penetration);

  next.wall_work = before.wall_work + outcome.wall_work;
  next.friction_loss = before.friction_loss + outcome.friction_loss;
  next.shock_loss = before.shock_loss + outcome.shock_loss;
  report.energy = {.kinetic = now.kinetic,
                   .potential = now.potential,
                   .wall_work = next.wall_work,
                   .friction_loss = next.friction_loss,
                   .shock_loss = next.shock_loss};
  report.energy.imbalance = now.kinetic + now.potential - then.kinetic - then.potential -
                            outcome.wall_work + outcome.friction_loss + outcome.shock_loss;
  if (!std::isfinite(report.energy.kinetic + report.energy.potential)) {
    throw StepFailure(StepFailure::Kind::kNumerical, before, "the energy is not finite");
  }
  report.momentum = now.momentum;
  report.momentum_imbalance = now.momentum - then.momentum - outcome.external;
  report.step = next.step;
  report.time = next.time;
  report.contacts = step.contacts.whole;
  report.active = static_cast<int>(active);
  report.penetration = penetration[0];
}

template <int D>
DomainReport<D> DomainStepper<D>::advance(DomainState<D>& state) {
  DomainReport<D> out;
  Stopwatch watch;
  Step step;
  Traffic before = group_.traffic();
  detect(state, step);
  counts_.detection.add_since(before, group_.traffic());
  before = group_.traffic();
  out.report.detection_seconds = watch.lap();
  last_.reset();  // before the next one needs its memory
  // Built in its place: moved, Eigen's matrices would be copied.
  last_.reset(new DomainPiece(
      assemble_piece(scene_, step.local, step.mid, step.contacts, state.bodies, group_)));
  release(step.contacts.all);
  out.report.assembly_seconds = watch.lap();
  step.solved.result.s = solve(state, step, out);
  out.report.solve_seconds = watch.lap();
  State<D> next = move(state, step);
  close_ledger(state.here, step, next, out);
  counts_.solve.add_since(before, group_.traffic());
  const int here = static_cast<int>(step.local.numbers.size());
  for (ContactOutcome<D>& c : step.outcome.contacts) {
    c.contact.i = step.local.numbers[to_size(c.contact.i)];
    c.contact.j = c.contact.j < here ? step.local.numbers[to_size(c.contact.j)]
                                     : state.bodies + c.contact.j - here;
  }
  next.contacts = std::move(step.outcome.contacts);
  state.here = std::move(next);
  ++counts_.steps;
  send_bodies(state);
  return out;
}

template <int D>
void DomainStepper<D>::send_bodies(DomainState<D>& state) {
  const Traffic before = group_.traffic();
  const double here[1] = {static_cast<double>(state.numbers.size() + state.here.contacts.size())};
  const double uneven = imbalance(group_.gather(here));
  counts_.imbalance = std::max(counts_.imbalance, uneven);
  if (after_cut_ == 0) after_cut_ = uneven;
  const bool asked = options_.cut_every > 0 && counts_.steps % options_.cut_every == 0;
  if (asked || uneven > std::max(options_.most_imbalance, kWorseThanAfterCut * after_cut_)) {
    cells_ = cut_cells_again(state, group_);
    after_cut_ = 0;
    ++counts_.cuts;
  }
  counts_.migrated += migrate(cells_, group_, state);
  counts_.migration.add_since(before, group_.traffic());
}

template <int D>
ContactProblem DomainStepper<D>::gather_last_problem() {
  return gather_problem(last_->piece, group_);
}

template std::string needs_whole_state(const Scene<2>&);
template std::string needs_whole_state(const Scene<3>&);
template class DomainStepper<2>;
template class DomainStepper<3>;

}  // namespace bipot
