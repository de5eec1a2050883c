#pragma once

#include <string_view>
#include <vector>

#include "solvers/parallel/distributed_space.h"
#include "solvers/parallel/problem_piece.h"
#include "solvers/parallel/process_group.h"
#include "solvers/solver.h"

namespace bipot {

/// Distribution of a problem.
struct DistributedOptions {
  bool reproducible = false;  ///< exact sums: apgd has the same bits for any number of processes
  /// Positions of the contacts, for the partition; empty if unknown: the contact graph decides.
  std::vector<Vec3> contact_places;
  int shared_factor_rows = kSharedFactorRows;
};

struct DistributedResult {
  /// Counts of a parallel solve, the same on all processes.
  struct Counts {
    int processes = 1;
    double imbalance = 1;   ///< most contacts of a process over their mean
    int most_contacts = 0;  ///< owned by one process
    int most_halo = 0;      ///< copies of others' contacts on one process
    /// Of the solve without its set-up; messages and bytes of the process with the most.
    ProcessGroup::Traffic traffic;
  };
  SolveResult result;  ///< s and u of the whole, on every process
  Counts counts;
};

/// solve() (solvers/solve.h) on all processes of the group: the same refusals, statuses and
/// messages, and the same last judgement on the original data, evaluated by all. `problem`,
/// `options` and `extra` must be the same on every process: sums over them are compared, and
/// CommonFailure is thrown if they differ. Each process cuts its part (ProblemPiece) from the
/// whole. Set-up and result therefore take memory and time of the whole on every process; the
/// iteration takes those of the part. All processes have the same bits, which depend on their
/// number.
///
/// Limits, unlike solve(): no islands, and no change of units of data beyond 1e±240. One process
/// may throw alone (memory, MPI): its caller must then end them all.
DistributedResult distributed_solve(std::string_view solver, const ContactProblem& problem,
                                    const SolverOptions& options, ProcessGroup& group,
                                    const DistributedOptions& extra = {});

/// Result on one process for a distributed problem.
struct PieceResult {
  SolveResult result;  ///< s and u of the owned contacts; else of the whole, the same everywhere
  Vector with_halo;    ///< s in the rows of ProblemPiece::with_halo
  std::vector<double> everywhere_momentum;  ///< H s in the rows that every process has
  DistributedResult::Counts counts;
};

/// The same for a distributed problem, to which each process brings its part. options.s0 has the
/// rows of piece.own, or is empty on all processes; contact_places is not used. Only the root
/// process may hold the whole: for a solver that runs there, or for a claim that is proved in more
/// than double precision (whole_problem.h).
PieceResult distributed_solve(std::string_view solver, const ProblemPiece& piece,
                              const SolverOptions& options, ProcessGroup& group,
                              const DistributedOptions& extra = {});

}  // namespace bipot
