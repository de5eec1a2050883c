#pragma once

#include "core/motion/assembly.h"
#include "core/motion/midpoint.h"
#include "solvers/parallel/problem_piece.h"
#include "solvers/simulation/local_contacts.h"

namespace bipot {

/// A step's problem of one process, assembled from what it has, and the way back to the bodies.
struct DomainPiece {
  ProblemPiece piece;     ///< its `own` is that of the step below
  AssembledStep own;      ///< of the own contacts; its problem has gone into the piece
  DofMap with_halo;       ///< where the bodies stand in the piece's with_halo
  std::vector<int> wall;  ///< of each degree of freedom that every process has
};

/// Exchanges two problems without the copies that std::swap and moves make of Eigen's sparse
/// matrices: a piece is most of what a process has.
void exchange(ContactProblem& a, ContactProblem& b);

/// The piece that cut_piece() would cut from the whole for these owners, but for bodies with many
/// contacts, which do not stand on every process here: only driven walls do, and bodies' velocities
/// are sums in the order of the whole without exception. Halo and own bodies' contacts are those of
/// `contacts`. Collective.
template <int D>
DomainPiece assemble_piece(const Scene<D>& scene, const LocalBodies<D>& local,
                           const Midpoint<D>& mid, const LocalContacts<D>& contacts, int bodies,
                           ProcessGroup& group);

}  // namespace bipot
