#include "core/problem/disk_structure.h"

#include <cmath>

#include "core/problem/structure_reader.h"

namespace bipot {
namespace {

/// One column of H spread over the two bodies of a contact.
template <int kDofs>
struct Wrench {
  double side[2][3] = {};

  /// False if the column touches another body.
  bool read(const SparseMatrix& H, int column, const RowOwners<kDofs>& owners, const int body[2]) {
    for (SparseMatrix::InnerIterator it(H, column); it; ++it) {
      if (it.value() == 0) continue;
      const int row = static_cast<int>(it.row());
      const int owner = owners.of(row);
      if (owner != body[0] && owner != body[1]) return false;
      side[owner == body[0] ? 0 : 1][owners.place(row)] = it.value();
    }
    return true;
  }
};

template <int D>
class DiskReader : StructureReader<DiskStructure, 2, D == 1 ? 2 : 3> {
 public:
  static constexpr int kDofs = D == 1 ? 2 : 3;
  using Base = StructureReader<DiskStructure, 2, kDofs>;
  using Base::Base;

  std::optional<DiskStructure> read() {
    return this->read_all([this](int c) { return read_contact(c); });
  }

 private:
  using Base::arm_, Base::out_, Base::owners_, Base::p_;

  bool read_contact(int c) {
    DiskStructure::Contact& contact = out_.contacts.emplace_back();
    int body[2] = {-1, -1};
    for (SparseMatrix::InnerIterator it(p_.H, c * D); it; ++it) {
      if (it.value() == 0) continue;
      const int owner = owners_.of(static_cast<int>(it.row()));
      if (body[0] < 0 || owner == body[0]) {
        body[0] = owner;
      } else if (body[1] < 0 || owner == body[1]) {
        body[1] = owner;
      } else {
        return false;
      }
    }
    if (body[0] < 0 || body[0] >= owners_.bodies) return false;
    const bool wall = body[1] >= owners_.bodies, disk = body[1] >= 0 && !wall;
    contact.i = body[0];
    contact.j = body[1] >= 0 ? body[1] : owners_.bodies + out_.walls;

    Wrench<kDofs> w;
    if (!w.read(p_.H, c * D, owners_, body)) return false;
    // Not hypot(), whose last bit depends on the processor.
    const double length = std::sqrt(w.side[0][0] * w.side[0][0] + w.side[0][1] * w.side[0][1]);
    for (int k = 0; k < 2; ++k) {
      contact.n[k] = w.side[0][k] / length;
      if (disk && !same_to_rounding(w.side[1][k], -w.side[0][k], length)) return false;
    }
    if (wall && !(same_to_rounding(std::abs(w.side[1][0]), length, length) &&
                  this->same_normal(contact.j, contact.n))) {
      return false;
    }
    contact.normal = length;
    if constexpr (D == 2) {
      if (w.side[0][2] != 0 || w.side[1][2] != 0) return false;
      Wrench<kDofs> t;
      if (!t.read(p_.H, c * D + 1, owners_, body)) return false;
      const double direction[2] = {-contact.n[1], contact.n[0]};
      const double factor = t.side[0][0] * direction[0] + t.side[0][1] * direction[1];
      if (!(factor > 0)) return false;
      contact.tangential = factor;
      for (int k = 0; k < 2; ++k) {
        const double expected = factor * direction[k];
        if (!same_to_rounding(t.side[0][k], expected, factor)) return false;
        if (body[1] >= 0 && !same_to_rounding(t.side[1][k], disk ? -expected : 0, factor))
          return false;
      }
      for (int side = 0; side < (disk ? 2 : 1); ++side) {
        const double arm = -t.side[side][2] / factor;
        double& known = arm_[to_size(body[side])];
        if (known != known) known = arm;
        if (!same_to_rounding(arm, known, std::abs(known))) return false;
      }
    }
    return true;
  }
};

template <int D>
std::optional<DiskStructure> read_disks(const ContactProblem& p) {
  const Vector mass = p.A.diagonal();
  return read_with_walls(p.num_dofs(), DiskReader<D>::kDofs,
                         [&](int walls) { return DiskReader<D>(p, mass, walls).read(); });
}

}  // namespace

std::optional<DiskStructure> disk_structure(const ContactProblem& p) {
  if (!p.has_velocities() || p.dim > 2 || p.rolls() || !is_diagonal(p.A)) return {};
  return p.dim == 1 ? read_disks<1>(p) : read_disks<2>(p);
}

}  // namespace bipot
