#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/motion/time_stepping.h"
#include "solvers/parallel/distributed_solve.h"
#include "solvers/simulation/domain_piece.h"
#include "solvers/simulation/domain_state.h"

namespace bipot {

/// Why the state of a scene cannot lie on several processes, in a few words; empty where it can.
template <int D>
std::string needs_whole_state(const Scene<D>& scene);

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
  Traffic solve;      ///< with assembly and what is added up after it
  Traffic migration;  ///< and new cells
  int gathers = 0;    ///< of the whole state, by who writes it
  Traffic gathering;
};
/// The largest of all processes, one by one; bodies that went are added up. Collective.
DomainCounts largest_counts(const DomainCounts& mine, ProcessGroup& group);

/// Contacts push walls with this much, of a step (solvers/simulation/force_energy.h): Σ |s| at walls.
template <int D>
struct DomainReport {
  StepReport<D> report;
  double wall_pushes = 0;  ///< [N s]
};

/// TimeStepper (core/motion/time_stepping.h) for a state that lies on several processes: the same
/// scheme, the same problems, the same ledger, but for the order of its sums. Each process detects,
/// assembles and moves what is its own; nobody holds the whole. Everything is collective.
template <int D>
class DomainStepper {
 public:
  /// Solves the problem of these pieces from a start in the rows of piece.own, or of size 0 on all.
  using Solver = std::function<PieceResult(const ProblemPiece& piece, const Vector& s0)>;
  /// Keeps references. needs_whole_state(scene) is empty.
  DomainStepper(const Scene<D>& scene, ProcessGroup& group, Solver solver,
                const DomainOptions& options = {});

  /// Cuts the state, which all processes have, and takes its part of it.
  DomainState<D> begin(const State<D>& whole);
  /// Takes one step, then sends bodies to whose cell they have come into. Throws StepFailure on all
  /// processes, leaving the state as it was, where TimeStepper does; CommonFailure where detection
  /// refuses.
  DomainReport<D> advance(DomainState<D>& state);
  /// The problem of the last step that was tried on the first process, an empty one elsewhere. There
  /// must have been one. Collective.
  ContactProblem gather_last_problem();

  const DomainCounts& counts() const { return counts_; }

 private:
  struct Step;
  void detect(const DomainState<D>& state, Step& step);
  Vector solve(const DomainState<D>& state, Step& step, DomainReport<D>& out);
  State<D> move(const DomainState<D>& state, Step& step);
  void close_ledger(const State<D>& before, Step& step, State<D>& next, DomainReport<D>& out);
  void send_bodies(DomainState<D>& state);

  const Scene<D>& scene_;
  ProcessGroup& group_;
  Solver solver_;
  DomainOptions options_;
  CellTree cells_;
  double after_cut_ = 0;               // imbalance that the last cut left; 0: not seen yet
  std::unique_ptr<DomainPiece> last_;  // of the last step
  DomainCounts counts_;
};

}  // namespace bipot
