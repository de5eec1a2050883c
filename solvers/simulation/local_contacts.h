#pragma once

#include <vector>

#include "core/motion/midpoint.h"
#include "solvers/simulation/ghost_bodies.h"

namespace bipot {

/// The contacts of a step that one process needs. A contact belongs to the owner of its body i. The
/// order is that of the whole, (i, j) in the whole's numbers; the positions of bodies in
/// LocalBodies have the same order. Included are the own contacts, and those of others (the halo)
/// that touch a body of its own or of its own contacts.
template <int D>
struct LocalContacts {
  std::vector<Contact<D>> own;   ///< i and j: positions in LocalBodies, j = its size + wall
  std::vector<Contact<D>> all;   ///< own ones and halo, likewise
  std::vector<int> owned, halo;  ///< places in `all`
  std::vector<int> number;       ///< of each own one in the whole
  std::vector<ProcessGroup::RemoteItem> copies;  ///< of each halo contact: owner and place there
  int whole = 0;                                 ///< of all processes
};

/// Finds the contacts among these bodies, own ones with the bits of detect_contacts() on the whole
/// (core/scene/contact_detection.h). Numbers in the whole are counted by all processes, each for a
/// range of bodies. Positions of the halo come from the owners. `mid`: of the same bodies.
/// Collective. Throws CommonFailure if detection fails, or if two processes find different
/// contacts.
template <int D>
LocalContacts<D> find_local_contacts(const Scene<D>& scene, const LocalBodies<D>& local,
                                     const Midpoint<D>& mid, int bodies, ProcessGroup& group);

}  // namespace bipot
