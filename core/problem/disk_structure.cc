#include "core/problem/disk_structure.h"

#include <cmath>
#include <limits>

#include "core/base/types.h"

namespace bipot {
namespace {

constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();

bool close(double x, double y, double size) { return std::abs(x - y) <= kRounding * size; }

/// One column of H spread over the two bodies of a contact.
struct Wrench {
  double side[2][3] = {};

  /// False if the column touches another body.
  bool read(const SparseMatrix& H, int column, int dofs, const int body[2]) {
    for (SparseMatrix::InnerIterator it(H, column); it; ++it) {
      if (it.value() == 0) continue;
      const int owner = static_cast<int>(it.row()) / dofs;
      const int k = static_cast<int>(it.row()) % dofs;
      if (owner == body[0]) {
        side[0][k] = it.value();
      } else if (owner == body[1]) {
        side[1][k] = it.value();
      } else {
        return false;
      }
    }
    return true;
  }
};

template <int D>
class Reader {
 public:
  explicit Reader(const ContactProblem& p) : p_(p) {}

  std::optional<DiskStructure> read() {
    if (p_.num_dofs() % kDofs != 0 || !is_diagonal(p_.A)) return {};
    const int bodies = p_.num_dofs() / kDofs;
    const Vector mass = p_.A.diagonal();
    for (int k = 0; k < bodies; ++k) {
      if (mass[k * kDofs] != mass[k * kDofs + 1]) return {};
    }
    out_.bodies.resize(to_size(bodies) + 1);
    out_.contacts.resize(to_size(p_.num_contacts()));
    arm_.assign(to_size(bodies), kNaN);
    for (int c = 0; c < p_.num_contacts(); ++c) {
      if (!read_contact(c)) return {};
    }
    for (int k = 0; k < bodies; ++k) {
      DiskStructure::Body& body = out_.bodies[to_size(k)];
      const double arm = arm_[to_size(k)];
      body.inverse_mass = 1 / mass[k * kDofs];
      if (D == 2 && arm == arm) {
        body.inverse_inertia = arm * arm / mass[k * kDofs + kDofs - 1];
        body.arm = arm;
      }
    }
    return std::move(out_);
  }

 private:
  static constexpr int kDofs = D == 1 ? 2 : 3;

  bool read_contact(int c) {
    DiskStructure::Contact& contact = out_.contacts[to_size(c)];
    int body[2] = {-1, -1};
    for (SparseMatrix::InnerIterator it(p_.H, c * D); it; ++it) {
      if (it.value() == 0) continue;
      const int owner = static_cast<int>(it.row()) / kDofs;
      if (body[0] < 0 || owner == body[0]) {
        body[0] = owner;
      } else if (body[1] < 0 || owner == body[1]) {
        body[1] = owner;
      } else {
        return false;
      }
    }
    if (body[0] < 0) return false;
    const bool pair = body[1] >= 0;
    contact.i = body[0];
    contact.j = pair ? body[1] : out_.surroundings();

    Wrench w;
    if (!w.read(p_.H, c * D, kDofs, body)) return false;
    // Not hypot(), whose last bit depends on the processor.
    const double length = std::sqrt(w.side[0][0] * w.side[0][0] + w.side[0][1] * w.side[0][1]);
    for (int k = 0; k < 2; ++k) {
      contact.n[k] = w.side[0][k] / length;
      if (pair && !close(w.side[1][k], -w.side[0][k], length)) return false;
    }
    contact.normal = length;
    if constexpr (D == 2) {
      if (w.side[0][2] != 0 || w.side[1][2] != 0) return false;
      Wrench t;
      if (!t.read(p_.H, c * D + 1, kDofs, body)) return false;
      const double direction[2] = {-contact.n[1], contact.n[0]};
      const double factor = t.side[0][0] * direction[0] + t.side[0][1] * direction[1];
      if (!(factor > 0)) return false;
      contact.tangential = factor;
      for (int k = 0; k < 2; ++k) {
        if (!close(t.side[0][k], factor * direction[k], factor)) return false;
        if (pair && !close(t.side[1][k], -factor * direction[k], factor)) return false;
      }
      for (int side = 0; side < (pair ? 2 : 1); ++side) {
        const double arm = -t.side[side][2] / factor;
        double& known = arm_[to_size(body[side])];
        if (known != known) known = arm;
        if (!close(arm, known, std::abs(known))) return false;
      }
    }
    return true;
  }

  const ContactProblem& p_;
  DiskStructure out_;
  std::vector<double> arm_;  // NaN until a contact has shown it
};

}  // namespace

std::optional<DiskStructure> disk_structure(const ContactProblem& p) {
  if (!p.has_velocities() || p.dim > 2 || p.rolls()) return {};
  return p.dim == 1 ? Reader<1>(p).read() : Reader<2>(p).read();
}

}  // namespace bipot
