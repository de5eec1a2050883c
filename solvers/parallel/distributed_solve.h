#pragma once

#include <string_view>
#include <vector>

#include "solvers/parallel/distributed_space.h"
#include "solvers/parallel/problem_piece.h"
#include "solvers/parallel/process_group.h"
#include "solvers/solver.h"

namespace bipot {

/// How a problem is spread, and what the spread is made of.
struct DistributedOptions {
  bool reproducible = false;  ///< exact sums: apgd has the same bits for any number of processes
  /// Where the contacts are, for the partition; empty where nobody knows: the contact graph
  /// decides.
  std::vector<Vec3> contact_places;
  int shared_factor_rows = kSharedFactorRows;
};

/// What a distributed solve counted, the same on all processes.
struct DistributedCounts {
  int processes = 1;
  double imbalance = 1;   ///< most contacts of a process over their mean
  int most_contacts = 0;  ///< owned by one process
  int most_halo = 0;      ///< copies of others' contacts on one process
  /// Of the solve without its set-up; messages and bytes of the process with the most.
  Traffic traffic;
};

struct DistributedResult {
  SolveResult result;  ///< s and u of the whole, on every process
  DistributedCounts counts;
};

/// solve() (solvers/solve.h) on all processes of the group: the same refusals, statuses, messages
/// and the same last judgement on the original data, evaluated by all. `problem`, `options` and
/// `extra` must be the same on every process (sums over them are compared; CommonFailure where they
/// differ). Each cuts its piece (ProblemPiece) from the whole, so that
/// set-up and result take memory and time of the whole on every process; the iteration takes its
/// piece's. Results are the same bits on all processes, and for the same number of them.
///
/// Not done here, other than in solve(): islands; the change of units of data beyond 1e±240. One
/// process may throw where others do not (memory, MPI): its caller must then end them all.
DistributedResult distributed_solve(std::string_view solver, const ContactProblem& problem,
                                    const SolverOptions& options, ProcessGroup& group,
                                    const DistributedOptions& extra = {});

/// What a solve leaves on one process of a problem of which nobody has the whole.
struct PieceResult {
  SolveResult
      result;  ///< s and u of the owned contacts; the rest as of the whole, the same everywhere
  Vector with_halo;  ///< s in the rows of ProblemPiece::with_halo
  std::vector<double>
      everywhere_momentum;  ///< H s in the degrees of freedom that every process has
  DistributedCounts counts;
};

/// The same of the pieces of all processes, each of which brings its own: options.s0 has the rows
/// of piece.own, or is empty on all processes (contact_places are of no use here). Only the root
/// process may hold the whole: for a solver that runs there, or for a claim that is proved in more
/// than double precision (whole_problem.h).
PieceResult distributed_solve(std::string_view solver, const ProblemPiece& piece,
                              const SolverOptions& options, ProcessGroup& group,
                              const DistributedOptions& extra = {});

}  // namespace bipot
