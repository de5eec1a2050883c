#pragma once

#include "solvers/parallel/contact_owners.h"
#include "solvers/parallel/problem_piece.h"
#include "solvers/parallel/process_group.h"

namespace bipot {

/// All processes of this mpirun.
ProcessGroup& mpi_group();

/// What this process has of a problem cut for all of them.
inline ProblemPiece piece_here(const ContactProblem& p) {
  const BodyNodes nodes = body_nodes(p);
  return cut_piece(p, nodes, contact_owners(p, nodes, {}, mpi_group().size()), mpi_group().rank());
}

}  // namespace bipot
