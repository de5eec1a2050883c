#include "solvers/disks/rolling_disks.h"

namespace bipot {

std::optional<DiskStructure> rolling_disks(const ContactProblem& p) {
  if (!p.rolls() || p.dim != 3 || !p.has_velocities()) return {};
  ContactProblem plain{.dim = 2, .A = p.A, .mu = p.mu};
  plain.H.resize(p.num_dofs(), 2 * p.num_contacts());
  plain.H.reserve(p.H.nonZeros());
  for (int row = 0; row < 2 * p.num_contacts(); ++row) {
    plain.H.startVec(row);
    for (SparseMatrix::InnerIterator it(p.H, row / 2 * 3 + row % 2); it; ++it) {
      plain.H.insertBack(static_cast<int>(it.row()), row) = it.value();
    }
  }
  plain.H.finalize();
  std::optional<DiskStructure> disks = disk_structure(plain);
  if (!disks || disks->walls > 0) return {};
  for (int c = 0; c < p.num_contacts(); ++c) {
    const DiskStructure::Contact& contact = disks->contacts[to_size(c)];
    double first = 0, second = 0;
    for (SparseMatrix::InnerIterator it(p.H, 3 * c + 2); it; ++it) {
      const auto dof = static_cast<int>(it.row());
      if (dof == 3 * contact.i + 2) {
        first = it.value();
      } else if (dof == 3 * contact.j + 2) {
        second = it.value();
      } else if (it.value() != 0) {
        return {};
      }
    }
    const bool pair = contact.j != disks->surroundings();
    const auto arm = [&](int body) { return disks->bodies[to_size(body)].arm; };
    if (!(arm(contact.i) > 0) || (pair && !(arm(contact.j) > 0))) return {};
    if (!(first > 0) || second != (pair ? -first : 0)) return {};
  }
  return disks;
}

}  // namespace bipot
