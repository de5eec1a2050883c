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
  /// Cells are cut again where the bodies and contacts of one process are more than this over their
  /// mean.
  double most_imbalance = 1.2;
  int cut_every = 0;  ///< steps after which cells are cut again in any case; 0: never
};

/// What the steps of one process counted; messages and bytes are those that it sent.
struct DomainCounts {
  int steps = 0;
  int cuts = 0;               ///< how often cells were cut again
  std::int64_t migrated = 0;  ///< bodies that went from here to others
  int most_bodies = 0, most_ghosts = 0, most_contacts = 0, most_halo = 0;  ///< in a step
  /// Most bodies and contacts of one process over their mean, largest of the steps.
  double imbalance = 1;
  Traffic detection;  ///< ghosts, numbers and places of contacts
  Traffic solve;      ///< with assembly and the sums after it
  Traffic migration;  ///< and new cells
  int gathers = 0;    ///< of the whole state
  Traffic gathering;
};
/// The largest of all processes, one by one; bodies that went are added up. Collective.
DomainCounts largest_counts(const DomainCounts& mine, ProcessGroup& group);

/// One process's part of a state that lies on several, for TimeStepper
/// (core/motion/time_stepping.h): its bodies, copies of those around, its contacts and their
/// problem. Steps have the bits of one process where the solver's have, but for the order of the
/// ledger's sums; nobody holds the whole. Everything but state() and counts() is collective.
template <int D>
class Domain final : public Neighbours<D> {
 public:
  /// Solves the problem of these pieces from a start in the rows of piece.own, or of size 0 on all.
  using Solver = std::function<PieceResult(const ProblemPiece& piece, const Vector& s0)>;
  /// Cuts `whole`, which all processes have and which may go afterwards. Keeps references to scene
  /// and group.
  Domain(const Scene<D>& scene, const State<D>& whole, ProcessGroup& group, Solver solver,
         const DomainOptions& options = {});

  /// The state to advance: bodies and contacts of this process, with contacts numbered in the
  /// whole.
  State<D>& state() { return state_.here; }
  /// The whole on the first process, a state without bodies and contacts elsewhere.
  State<D> gather();
  /// The problem of the last step that was tried on the first process, an empty one elsewhere.
  /// There must have been one.
  ContactProblem gather_problem();
  const DomainState<D>& own() const { return state_; }
  const DomainCounts& counts() const { return counts_; }

  /// Throws CommonFailure where detection refuses.
  Midpoint<D> midpoint() override;
  const AssembledStep& assemble(Midpoint<D>& mid) override;
  const ContactProblem& problem() const override { return last_->piece.own; }
  StepSolution solve(const Vector& s0) override;
  State<D> move(const Midpoint<D>& mid, Vector& v) override;
  void number(Contact<D>& contact) const override;
  void settle() override;
  bool counts_walls() const override { return group_.rank() == 0; }
  bool all(bool mine) override { return !group_.any(!mine); }
  void sum(std::span<double> values) override { group_.sum(values); }
  void largest(std::span<double> values) override { group_.largest(values); }

 private:
  const Scene<D>& scene_;
  ProcessGroup& group_;
  Solver solver_;
  DomainOptions options_;
  CellTree cells_;
  double after_cut_ = 0;  // imbalance that the last cut left; 0: not seen yet
  DomainState<D> state_;
  LocalBodies<D> local_;               // of this step
  LocalContacts<D> contacts_;          // of this step; the own ones have gone into the midpoint
  std::unique_ptr<DomainPiece> last_;  // of the last step
  PieceResult solved_;
  DomainCounts counts_;
  Traffic detected_;  // reading after the detection of this step
};

}  // namespace bipot
