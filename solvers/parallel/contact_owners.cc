#include "solvers/parallel/contact_owners.h"

#include "solvers/parallel/cell_tree.h"

namespace bipot {

ContactOwners contact_owners(const ContactProblem& p, const BodyNodes& nodes,
                             const std::vector<Vec3>& contact_places, int processes) {
  const std::vector<Vec3> places = node_places(p, nodes, contact_places);
  const CellTree cells(places, nodes.contacts, processes);
  std::vector<int> owner(places.size());
  for (std::size_t k = 0; k < places.size(); ++k) owner[k] = cells.cell_of(places[k]);
  return contact_owners(nodes, owner, processes);
}

ContactOwners contact_owners(const BodyNodes& nodes, const std::vector<int>& node_owner,
                             int processes) {
  ContactOwners owners{.processes = processes};
  owners.contacts.assign(to_size(processes), 0);
  owners.owner.resize(nodes.first.size());
  for (std::size_t c = 0; c < nodes.first.size(); ++c) {
    const int node = nodes.first[c];
    owners.owner[c] = node >= 0 ? node_owner[to_size(node)] : static_cast<int>(c) % processes;
    ++owners.contacts[to_size(owners.owner[c])];
  }
  return owners;
}

}  // namespace bipot
