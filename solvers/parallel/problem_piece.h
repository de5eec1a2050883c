#pragma once

#include <memory>
#include <vector>

#include "core/problem/contact_problem.h"
#include "solvers/parallel/body_nodes.h"
#include "solvers/parallel/contact_owners.h"
#include "solvers/parallel/process_group.h"

namespace bipot {

/// What one process has of a problem that lies on several. It owns contacts, and has copies of all
/// other contacts of its contacts' bodies (the halo): with the impulses of the halo copied from
/// their owners, its bodies' velocities are sums over all of their contacts, in the order of the
/// whole problem. One exchange so makes u = W s of its contacts with the bits of one process, where
/// forces on ghost bodies would take two (forces to the owner, velocities back) and other bits.
struct ProblemPiece {
  int whole_contacts = 0;  ///< of all processes
  /// The owned contacts with all degrees of freedom that they touch, true masses, as a problem.
  ContactProblem own;
  /// Owned contacts and halo in the order of the whole; without the degrees of freedom that every
  /// process has. Bodies that only the halo touches lack contacts: their velocities mean nothing.
  ContactProblem with_halo;
  std::vector<int> dof_with_halo;  ///< of each degree of freedom of `own` its place there; -1: none
  std::vector<int> owned;          ///< places in with_halo of the owned contacts, ascending
  std::vector<int> halo;           ///< places in with_halo of the others, ascending
  std::vector<int> number;         ///< of each owned contact in the whole, ascending
  /// For each degree of freedom of `own` a number that it has in the whole, ascending; those of all
  /// processes together are in the order of the whole, with or without gaps.
  std::vector<int> dof_number;
  std::vector<RemoteItem> copies;  ///< for each contact of the halo: its owner and its place there
  /// For each degree of freedom of `own`: how many processes own contacts of its body.
  std::vector<int> sharers;

  /// H of the degrees of freedom that every process has: one entry of a row of `own`.
  struct EverywhereEntry {
    int row = 0, dof = 0;  ///< dof: place in everywhere_mass
    double value = 0;
  };
  std::vector<EverywhereEntry> everywhere;
  std::vector<double> everywhere_inverse_mass;  ///< the same on every process
  std::vector<int> everywhere_own_dof;          ///< place in `own`; -1: no owned contact there
  bool disks = false;  ///< the whole problem is one of disks (core/problem/disk_structure.h)
};

/// Why a problem cannot lie on several processes, in one sentence; empty where it can. A and H are
/// needed, A diagonal.
std::string refuse_distributed(const ContactProblem& problem);

/// Cuts the piece of process `rank`. Cost: a pass over the whole.
ProblemPiece cut_piece(const ContactProblem& whole, const BodyNodes& nodes,
                       const ContactOwners& owners, int rank);

}  // namespace bipot
