#pragma once

#include "core/motion/assembly.h"
#include "core/motion/midpoint.h"
#include "solvers/parallel/problem_piece.h"
#include "solvers/simulation/local_contacts.h"

namespace bipot {

/// A step's problem on one process, assembled from its own data, and the map back to the bodies.
struct DomainPiece {
  ProblemPiece piece;     ///< its `own` is that of the step below
  AssembledStep own;      ///< of the own contacts; its problem has been moved into the piece
  DofMap with_halo;       ///< where the bodies stand in the piece's with_halo
  std::vector<int> wall;  ///< of each degree of freedom that every process has
};

/// Exchanges two problems without copies, which std::swap makes of Eigen's sparse matrices: a piece
/// is most of the memory of a process.
void exchange(ContactProblem& a, ContactProblem& b);

/// The piece that cut_piece() would cut from the whole for these owners, except that bodies with
/// many contacts are not copied to every process. Only driven walls are; velocities of bodies are
/// always sums in the order of the whole. Halo and own bodies' contacts are those of `contacts`.
/// Collective.
template <int D>
DomainPiece assemble_piece(const Scene<D>& scene, const LocalBodies<D>& local,
                           const Midpoint<D>& mid, const LocalContacts<D>& contacts, int bodies,
                           ProcessGroup& group);

}  // namespace bipot
