#include "core/problem/sphere_structure.h"

#include <cmath>
#include <limits>
#include <vector>

#include "core/base/types.h"

namespace bipot {
namespace {

constexpr double kTolerance = 16 * std::numeric_limits<double>::epsilon();
constexpr int kOfBody = 6;  // degrees of freedom

bool near(double x, double y, double size) { return std::abs(x - y) <= kTolerance * size; }

double dot3(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

class SphereReader {
 public:
  explicit SphereReader(const ContactProblem& p) : p_(p) {}

  std::optional<SphereStructure> read() {
    if (p_.num_dofs() % kOfBody != 0 || !is_diagonal(p_.A)) return {};
    const int bodies = p_.num_dofs() / kOfBody;
    const Vector mass = p_.A.diagonal();
    for (int k = 0; k < p_.num_dofs(); ++k) {
      if (mass[k] != mass[k / 3 * 3]) return {};
    }
    out_.bodies.resize(to_size(bodies) + 1);
    out_.contacts.resize(to_size(p_.num_contacts()));
    arm_.assign(to_size(bodies), kNaN);
    for (int c = 0; c < p_.num_contacts(); ++c) {
      if (!read_contact(c)) return {};
    }
    for (int k = 0; k < bodies; ++k) {
      SphereStructure::Body& body = out_.bodies[to_size(k)];
      const double arm = arm_[to_size(k)];
      body.inverse_mass = 1 / mass[k * kOfBody];
      if (arm == arm) body.inverse_inertia = arm * arm / mass[k * kOfBody + 3];
    }
    return std::move(out_);
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
        const int owner = static_cast<int>(it.row()) / kOfBody;
        int side = 0;
        if (body[0] < 0) body[0] = owner;
        if (owner != body[0]) {
          side = 1;
          if (body[1] < 0) body[1] = owner;
          if (owner != body[1]) return false;
        }
        columns.side[k][side][it.row() % kOfBody] = it.value();
      }
    }
    if (body[0] < 0) return false;
    const int sides = body[1] >= 0 ? 2 : 1;
    SphereStructure::Contact& contact = out_.contacts[to_size(c)];
    contact.i = body[0];
    contact.j = sides == 2 ? body[1] : out_.surroundings();
    return read_frame(columns, sides, contact) && read_arms(columns, sides, body, contact);
  }

  /// Forces on the bodies: an orthonormal frame, opposite on the second one.
  static bool read_frame(const Columns& columns, int sides, SphereStructure::Contact& contact) {
    for (int k = 0; k < 3; ++k) {
      const double* const force = columns.side[k][0];
      const double length = std::sqrt(dot3(force, force));
      if (!(length > 0)) return false;
      for (int x = 0; x < 3; ++x) {
        contact.frame[k][x] = force[x] / length;
        if (sides == 2 && !near(columns.side[k][1][x], -force[x], length)) return false;
      }
      for (int before = 0; before < k; ++before) {
        if (!near(dot3(contact.frame[k], contact.frame[before]), 0, 1)) return false;
      }
      if (k == 2 && !near(length, contact.tangential, length)) return false;
      (k == 0 ? contact.normal : contact.tangential) = length;
    }
    return true;
  }

  /// Torques: none of the normal force, -arm n x t of a tangential one on either body.
  bool read_arms(const Columns& columns, int sides, const int body[2],
                 const SphereStructure::Contact& contact) {
    const double* const n = contact.frame[0];
    for (int side = 0; side < sides; ++side) {
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
          if (!near(torque[x], expected, size)) return false;
        }
      }
    }
    return true;
  }

  const ContactProblem& p_;
  SphereStructure out_;
  std::vector<double> arm_;  // NaN until a contact has shown it
};

}  // namespace

std::optional<SphereStructure> sphere_structure(const ContactProblem& p) {
  if (!p.has_velocities() || p.dim != 3 || p.rolls()) return {};
  return SphereReader(p).read();
}

}  // namespace bipot
