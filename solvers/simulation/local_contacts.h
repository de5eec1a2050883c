#pragma once

#include <vector>

#include "core/motion/midpoint.h"
#include "solvers/simulation/ghost_bodies.h"

namespace bipot {

/// The contacts of a step that one process needs. They belong to the owner of their body i, in the
/// order of the whole, (i, j) of the whole's numbers; the bodies' places in LocalBodies have the
/// same order. Here are its own ones, and those of others (the halo) that touch a body of its own
/// or of its own contacts.
template <int D>
struct LocalContacts {
  std::vector<Contact<D>> own;     ///< i and j: places in LocalBodies, j = its size + wall
  std::vector<Contact<D>> all;     ///< own ones and halo, likewise
  std::vector<int> owned, halo;    ///< places in `all`
  std::vector<int> number;         ///< of each own one in the whole
  std::vector<RemoteItem> copies;  ///< for each of the halo: its owner and its place there
  int whole = 0;                   ///< of all processes
};

/// Finds the contacts among these bodies, own ones with the bits of detect_contacts() on the whole
/// (core/scene/contact_detection.h). Numbers in the whole come from as many processes as there are,
/// each of which counts for a range of bodies; places of the halo from the owners. `mid`: of the
/// same bodies. Collective. Throws CommonFailure where detection refuses, or where two processes
/// see different contacts.
template <int D>
LocalContacts<D> find_local_contacts(const Scene<D>& scene, const LocalBodies<D>& local,
                                     const Midpoint<D>& mid, int bodies, ProcessGroup& group);

}  // namespace bipot
