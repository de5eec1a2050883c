#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "core/motion/neighbours.h"
#include "solvers/parallel/distributed_solve.h"
#include "solvers/simulation/domain_piece.h"
#include "solvers/simulation/domain_state.h"

namespace bipot {

struct DomainOptions {
  /// Called with each solution; may change it, alike on all processes.
  std::function<void(StepSolution&)> review;
  int cut_every = 0;  ///< number of steps after which cells are cut again in any case; 0: never
};

/// Counts over the steps of one process; messages and bytes are those that it sent.
struct DomainCounts {
  int steps = 0;
  int cuts = 0;               ///< how often cells were cut again
  std::int64_t migrated = 0;  ///< bodies that went from here to others
  int most_bodies = 0, most_ghosts = 0, most_contacts = 0, most_halo = 0;  ///< in a step
  /// Bodies and contacts of the process with the most, over their mean, largest of the steps.
  double imbalance = 1;
  ProcessGroup::Traffic detection;  ///< ghosts, numbers and places of contacts
  ProcessGroup::Traffic solve;      ///< with assembly and the sums after it
  ProcessGroup::Traffic migration;  ///< and new cells
  int gathers = 0;                  ///< of the whole state
  ProcessGroup::Traffic gathering;
};
/// The largest of all processes for each entry; migrated bodies are summed. Collective.
DomainCounts largest_counts(const DomainCounts& mine, ProcessGroup& group);

/// One process's part of a distributed state, for TimeStepper (core/motion/time_stepping.h): its
/// bodies, copies of nearby ones, its contacts and their problem. If the solver has the bits of one
/// process, so have the steps, except for the order of the ledger's sums. No process holds the
/// whole. All members but state() and counts() are collective.
template <int D>
class Domain final : public Neighbours<D> {
 public:
  /// Solves the problem of these pieces from a start in the rows of piece.own, or of size 0 on all.
  using Solver = std::function<PieceResult(const ProblemPiece& piece, const Vector& s0)>;
  /// Cuts `whole`, which all processes have and which may be deleted afterwards. Keeps references
  /// to scene and group.
  Domain(const Scene<D>& scene, const State<D>& whole, ProcessGroup& group, Solver solver,
         const DomainOptions& options = {});

  /// The state to advance: bodies and contacts of this process; contacts have the numbers of the
  /// whole.
  State<D>& state() { return state_.here; }
  /// The whole on the root process, a state without bodies and contacts elsewhere.
  State<D> gather();
  /// The problem of the last attempted step on the root process, an empty one elsewhere. Requires
  /// such a step.
  ContactProblem gather_problem();
  const DomainState<D>& own() const { return state_; }
  const DomainCounts& counts() const { return counts_; }

  /// Throws CommonFailure if detection fails.
  Midpoint<D> midpoint() override;
  const AssembledStep& assemble(Midpoint<D>& mid) override;
  const ContactProblem& problem() const override { return last_->piece.own; }
  StepSolution solve(const Vector& s0) override;
  State<D> move(const Midpoint<D>& mid, Vector& v) override;
  void number(Contact<D>& contact) const override;
  int body_number(int index) const override { return state_.numbers[to_size(index)]; }
  void settle() override;
  bool counts_walls() const override { return group_.rank() == 0; }
  bool all(bool mine) override { return !group_.any(!mine); }
  void sum(std::span<double> values) override { group_.sum(values); }
  void largest(std::span<double> values) override { group_.largest(values); }
  std::vector<double> gather(std::span<const double> mine) override { return group_.gather(mine); }
  std::string first_text(const std::string& mine) override { return group_.first_text(mine); }

 private:
  const Scene<D>& scene_;
  ProcessGroup& group_;
  Solver solver_;
  DomainOptions options_;
  CellTree cells_;
  double after_cut_ = 0;  // imbalance after the last cut; 0: not known yet
  DomainState<D> state_;
  LocalBodies<D> local_;       // of this step
  LocalContacts<D> contacts_;  // of this step; the own ones have been moved into the midpoint
  std::unique_ptr<DomainPiece> last_;  // of the last step
  PieceResult solved_;
  DomainCounts counts_;
  ProcessGroup::Traffic detected_;  // reading after the detection of this step
};

}  // namespace bipot
