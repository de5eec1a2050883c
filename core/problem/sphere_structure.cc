#include "core/problem/sphere_structure.h"

#include <cmath>

#include "core/problem/structure_reader.h"

namespace bipot {
namespace {

constexpr int kOfBody = 6;  // degrees of freedom

double dot3(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

class SphereReader : StructureReader<SphereStructure, 3, kOfBody> {
 public:
  using StructureReader::StructureReader;

  std::optional<SphereStructure> read() {
    return read_all([this](int c) { return read_contact(c); });
  }

 private:
  /// The columns of a contact, spread over its two bodies.
  struct Columns {
    double side[3][2][kOfBody] = {};
  };

  bool read_contact(int c) {
    int body[2] = {-1, -1};
    Columns columns;
    for (int k = 0; k < 3; ++k) {
      for (SparseMatrix::InnerIterator it(p_.H, c * 3 + k); it; ++it) {
        if (it.value() == 0) continue;
        const int row = static_cast<int>(it.row()), owner = owners_.of(row);
        int side = 0;
        if (body[0] < 0) body[0] = owner;
        if (owner != body[0]) {
          side = 1;
          if (body[1] < 0) body[1] = owner;
          if (owner != body[1]) return false;
        }
        columns.side[k][side][owners_.place(row)] = it.value();
      }
    }
    if (body[0] < 0 || body[0] >= owners_.bodies) return false;
    SphereStructure::Contact& contact = out_.contacts.emplace_back();
    contact.i = body[0];
    contact.j = body[1] >= 0 ? body[1] : owners_.bodies + out_.walls;
    const int spheres = contact.j < owners_.bodies ? 2 : 1;
    return read_frame(columns, spheres, contact) && read_arms(columns, spheres, body, contact) &&
           (body[1] < owners_.bodies || read_wall(columns, contact));
  }

  /// Forces on the bodies: an orthonormal frame, opposite on the second one.
  static bool read_frame(const Columns& columns, int spheres, SphereStructure::Contact& contact) {
    for (int k = 0; k < 3; ++k) {
      const double* const force = columns.side[k][0];
      const double length = std::sqrt(dot3(force, force));
      if (!(length > 0)) return false;
      for (int x = 0; x < 3; ++x) {
        contact.frame[k][x] = force[x] / length;
        if (spheres == 2 && !same_to_rounding(columns.side[k][1][x], -force[x], length))
          return false;
      }
      for (int before = 0; before < k; ++before) {
        if (!same_to_rounding(dot3(contact.frame[k], contact.frame[before]), 0, 1)) return false;
      }
      if (k == 2 && !same_to_rounding(length, contact.tangential, length)) return false;
      (k == 0 ? contact.normal : contact.tangential) = length;
    }
    return true;
  }

  /// Torques: none of the normal force, -arm n x t of a tangential one on either body.
  bool read_arms(const Columns& columns, int spheres, const int body[2],
                 const SphereStructure::Contact& contact) {
    const double* const n = contact.frame[0];
    for (int side = 0; side < spheres; ++side) {
      double& arm = arm_[to_size(body[side])];
      for (int k = 0; k < 3; ++k) {
        const double* const torque = columns.side[k][side] + 3;
        const double* const t = contact.frame[k];
        const double turn[3] = {n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2],
                                n[0] * t[1] - n[1] * t[0]};
        if (k > 0 && arm != arm) arm = -dot3(torque, turn) / contact.tangential;
        for (int x = 0; x < 3; ++x) {
          const double expected = k == 0 ? 0 : -contact.tangential * arm * turn[x];
          const double size = k == 0 ? 0 : contact.tangential * std::abs(arm);
          if (!same_to_rounding(torque[x], expected, size)) return false;
        }
      }
    }
    return true;
  }

  /// A driven wall: pushed by the normal force alone, with the normal of its contacts before.
  bool read_wall(const Columns& columns, const SphereStructure::Contact& contact) {
    if (!same_to_rounding(std::abs(columns.side[0][1][0]), contact.normal, contact.normal))
      return false;
    for (int k = 1; k < 3; ++k) {
      if (!same_to_rounding(columns.side[k][1][0], 0, contact.tangential)) return false;
    }
    return same_normal(contact.j, contact.frame[0]);
  }
};

}  // namespace

std::optional<SphereStructure> sphere_structure(const ContactProblem& p) {
  if (!p.has_velocities() || p.dim != 3 || p.rolls() || !is_diagonal(p.A)) return {};
  const Vector mass = p.A.diagonal();
  return read_with_walls(p.num_dofs(), kOfBody,
                         [&](int walls) { return SphereReader(p, mass, walls).read(); });
}

}  // namespace bipot
