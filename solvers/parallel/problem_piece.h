#pragma once

#include <vector>

#include "core/problem/contact_problem.h"
#include "solvers/parallel/body_nodes.h"
#include "solvers/parallel/contact_owners.h"
#include "solvers/parallel/process_group.h"

namespace bipot {

/// One process's part of a distributed problem. It owns contacts, and has copies of all other
/// contacts of its contacts' bodies (the halo). With the impulses of the halo copied from their
/// owners, its bodies' velocities are sums over all of their contacts, in the order of the whole
/// problem. One exchange thus gives u = W s of its contacts with the bits of one process. Forces on
/// ghost bodies would need two (forces to the owner, velocities back) and give other bits.
struct ProblemPiece {
  int whole_contacts = 0;  ///< of all processes
  /// The owned contacts with all degrees of freedom that they touch, with true masses, as a
  /// problem.
  ContactProblem own;
  /// Owned contacts and halo in the order of the whole, without the degrees of freedom that every
  /// process has. Bodies that only the halo touches lack contacts: their velocities are not valid.
  ContactProblem with_halo;
  std::vector<int> dof_with_halo;  ///< of each degree of freedom of `own` its index there; -1: none
  std::vector<int> owned;          ///< places in with_halo of the owned contacts, ascending
  std::vector<int> halo;           ///< places in with_halo of the others, ascending
  std::vector<int> number;         ///< of each owned contact in the whole, ascending
  /// A number in the whole for each degree of freedom of `own`, ascending; those of all processes
  /// together are in the order of the whole, with or without gaps.
  std::vector<int> dof_number;
  std::vector<ProcessGroup::RemoteItem> copies;  ///< of each halo contact: owner and index there
  /// For each degree of freedom of `own`: number of processes that own contacts of its body.
  std::vector<int> sharers;

  /// H of the degrees of freedom that every process has: one entry of a row of `own`.
  struct EverywhereEntry {
    int row = 0, dof = 0;  ///< dof: place in everywhere_mass
    double value = 0;
  };
  std::vector<EverywhereEntry> everywhere;
  std::vector<double> everywhere_inverse_mass;  ///< the same on every process
  std::vector<int> everywhere_own_dof;          ///< place in `own`; -1: no owned contact there
  bool packed = false;  ///< the whole problem is one of disks or spheres (packed_bodies.h)
};

/// Reason why a problem cannot be distributed, in one sentence; empty if it can. A and H are
/// needed, A diagonal.
std::string refuse_distributed(const ContactProblem& problem);

/// Cuts the part of process `rank`. Cost: a pass over the whole.
ProblemPiece cut_piece(const ContactProblem& whole, const BodyNodes& nodes,
                       const ContactOwners& owners, int rank);

}  // namespace bipot
