#pragma once

#include <string_view>
#include <vector>

#include "solvers/distributed/process_group.h"
#include "solvers/solver.h"

namespace bipot {

/// How a problem is spread, and what the spread is made of.
struct DistributedOptions {
  bool reproducible = false;  ///< exact sums: apgd has the same bits for any number of processes
  /// Where the contacts are, for the partition; empty where nobody knows: the contact graph decides.
  std::vector<Vec3> contact_places;
  /// Rows from which led solvers (ipm) have their systems factored by all processes; the first one
  /// alone is quicker below (data/distributed.md).
  int shared_factor_rows = 20000;
};

/// What a distributed solve counted, the same on all processes.
struct DistributedCounts {
  int processes = 1;
  double imbalance = 1;   ///< most contacts of a process over their mean
  int most_contacts = 0;  ///< owned by one process
  int most_halo = 0;      ///< copies of others' contacts on one process
  /// Of the iteration alone; messages and bytes of the process with the most.
  Traffic traffic;
};

struct DistributedResult {
  SolveResult result;  ///< s and u of the whole, on every process
  DistributedCounts counts;
};

/// solve() (solvers/solve.h) on all processes of the group: the same refusals, statuses, messages and
/// the same last judgement on the original data, evaluated by all. `problem`, `options` and `extra`
/// must be the same on every process (sums over them are compared; CommonFailure where they differ).
/// Each cuts its piece (ProblemPiece) from the whole, so that
/// set-up and result take memory and time of the whole on every process; the iteration takes its
/// piece's. Results are the same bits on all processes, and for the same number of them.
///
/// Not done here, other than in solve(): islands; the change of units of data beyond 1e±240. One
/// process may throw where others do not (memory, MPI): its caller must then end them all.
DistributedResult distributed_solve(std::string_view solver, const ContactProblem& problem,
                                    const SolverOptions& options, ProcessGroup& group,
                                    const DistributedOptions& extra = {});

}  // namespace bipot
