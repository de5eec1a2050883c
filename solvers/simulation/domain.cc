#include "solvers/simulation/domain.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/release.h"
#include "core/motion/midpoint.h"
#include "core/problem/delassus.h"
#include "solvers/parallel/whole_problem.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

/// Cells are cut again if bodies and contacts of one process exceed this multiple of their mean.
constexpr double kMostImbalance = 1.2;
/// Growth of the imbalance since the last cut from which new cells are worth their messages.
constexpr double kWorseThanAfterCut = 1.1;

}  // namespace

DomainCounts largest_counts(const DomainCounts& mine, ProcessGroup& group) {
  DomainCounts all = mine;
  std::int64_t migrated[1] = {mine.migrated};
  group.sum(migrated);
  all.migrated = migrated[0];
  Buffer numbers;
  append(numbers, mine.most_bodies, mine.most_ghosts, mine.most_contacts, mine.most_halo);
  ProcessGroup::Traffic* const traffics[] = {&all.detection, &all.solve, &all.migration,
                                             &all.gathering};
  for (const ProcessGroup::Traffic* t : traffics) t->append_to(numbers);
  group.largest(numbers);
  BufferReader reader(numbers);
  reader.take(all.most_bodies, all.most_ghosts, all.most_contacts, all.most_halo);
  for (ProcessGroup::Traffic* t : traffics) t->read(reader);
  return all;
}

template <int D>
Domain<D>::Domain(const Scene<D>& scene, const State<D>& whole, ProcessGroup& group, Solver solver,
                  const DomainOptions& options)
    : scene_(scene),
      group_(group),
      solver_(std::move(solver)),
      options_(options),
      cells_(cut_cells(whole, group.size())),
      // Without known contacts, the first step may require other cells at once.
      after_cut_(whole.contacts.empty() ? 1 : 0),
      state_(cut_state(whole, cells_, group.rank())) {}

template <int D>
Midpoint<D> Domain<D>::midpoint() {
  const ProcessGroup::Traffic before = group_.traffic();
  local_ = with_ghosts(scene_, state_, group_);
  Midpoint<D> mid = free_midpoint(scene_, local_.state);
  release(local_.state.bodies);  // mid-step has them
  contacts_ = find_local_contacts(scene_, local_, mid, state_.bodies, group_);
  const auto most = [](int& most_of, std::size_t here) {
    most_of = std::max(most_of, static_cast<int>(here));
  };
  most(counts_.most_bodies, local_.own.size());
  most(counts_.most_ghosts, local_.numbers.size() - local_.own.size());
  most(counts_.most_contacts, contacts_.own.size());
  most(counts_.most_halo, contacts_.halo.size());
  detected_ = group_.traffic();
  counts_.detection.add_since(before, detected_);
  return mid;
}

template <int D>
const AssembledStep& Domain<D>::assemble(Midpoint<D>& mid) {
  last_.reset();  // before the next one needs its memory
  // Built in place: a move would copy Eigen's matrices.
  last_.reset(
      new DomainPiece(assemble_piece(scene_, local_, mid, contacts_, state_.bodies, group_)));
  release(contacts_.all);
  mid.contacts = std::move(contacts_.own);
  return last_->own;
}

template <int D>
StepSolution Domain<D>::solve(const Vector& s0) {
  solved_ = solver_(last_->piece, s0);
  StepSolution solution = to_step_solution(std::move(solved_.result));
  if (options_.review) options_.review(solution);
  return solution;
}

/// The velocity of a body with contacts here is the sum over all of its contacts, also over copies.
template <int D>
State<D> Domain<D>::move(const Midpoint<D>& mid, Vector& v) {
  const ProblemPiece& piece = last_->piece;
  const Vector bodies = piece.with_halo.num_contacts() > 0
                            ? body_velocities(piece.with_halo, solved_.with_halo)
                            : Vector();
  Midpoint<D> own;
  own.walls = mid.walls;
  own.wall_v_free = mid.wall_v_free;
  DofMap dofs;
  dofs.per_disk = last_->with_halo.per_disk;
  for (const int k : local_.own) {
    own.bodies.push_back(mid.bodies[to_size(k)]);
    own.disk_v_free.push_back(mid.disk_v_free[to_size(k)]);
    dofs.disk.push_back(last_->with_halo.disk[to_size(k)]);
  }
  dofs.wall.assign(own.walls.size(), -1);
  const std::size_t driven = last_->wall.size();
  Vector v_all(bodies.size() + static_cast<Eigen::Index>(driven));
  v_all.head(bodies.size()) = bodies;
  v.resize(piece.own.num_dofs());
  for (Eigen::Index row = 0; row < v.size(); ++row) {
    const int at = piece.dof_with_halo[to_size(row)];
    if (at >= 0) v[row] = bodies[at];
  }
  for (std::size_t k = 0; k < driven; ++k) {
    const std::size_t w = to_size(last_->wall[k]);
    const double speed =
        mid.wall_v_free[w] + piece.everywhere_inverse_mass[k] * solved_.everywhere_momentum[k];
    dofs.wall[w] = static_cast<int>(bodies.size() + static_cast<Eigen::Index>(k));
    v_all[dofs.wall[w]] = speed;
    if (piece.everywhere_own_dof[k] >= 0) v[piece.everywhere_own_dof[k]] = speed;
  }
  return update_bodies(own, dofs, v_all, scene_.step);
}

template <int D>
void Domain<D>::number(Contact<D>& contact) const {
  const int here = static_cast<int>(local_.numbers.size());
  contact.i = local_.numbers[to_size(contact.i)];
  contact.j =
      contact.j < here ? local_.numbers[to_size(contact.j)] : state_.bodies + contact.j - here;
}

template <int D>
void Domain<D>::settle() {
  const ProcessGroup::Traffic before = group_.traffic();
  counts_.solve.add_since(detected_, before);
  ++counts_.steps;
  local_ = {};
  contacts_ = {};
  solved_ = {};
  const double here[1] = {static_cast<double>(state_.numbers.size() + state_.here.contacts.size())};
  const double uneven = imbalance(group_.gather(here));
  counts_.imbalance = std::max(counts_.imbalance, uneven);
  if (after_cut_ == 0) after_cut_ = uneven;
  const bool asked = options_.cut_every > 0 && counts_.steps % options_.cut_every == 0;
  if (asked || uneven > std::max(kMostImbalance, kWorseThanAfterCut * after_cut_)) {
    cells_ = cut_cells_again(state_, group_);
    after_cut_ = 0;
    ++counts_.cuts;
  }
  counts_.migrated += migrate(cells_, group_, state_);
  counts_.migration.add_since(before, group_.traffic());
}

template <int D>
State<D> Domain<D>::gather() {
  const ProcessGroup::Traffic before = group_.traffic();
  State<D> whole = gather_state(state_, group_);
  counts_.gathering.add_since(before, group_.traffic());
  ++counts_.gathers;
  return whole;
}

template <int D>
ContactProblem Domain<D>::gather_problem() {
  return bipot::gather_problem(last_->piece, group_);
}

template class Domain<2>;
template class Domain<3>;

}  // namespace bipot
