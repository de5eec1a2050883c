#include "core/problem/disk_structure.h"

#include <cmath>
#include <limits>
#include <vector>

#include "core/base/types.h"
#include "core/problem/body_rows.h"

namespace bipot {
namespace {

constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();

bool close(double x, double y, double size) { return std::abs(x - y) <= kRounding * size; }

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
class Reader {
 public:
  static constexpr int kDofs = D == 1 ? 2 : 3;

  Reader(const ContactProblem& p, const Vector& mass, int walls)
      : p_(p),
        mass_(mass),
        owners_{(p.num_dofs() - walls) / kDofs},
        wall_normal_(to_size(walls), Vec2::Zero()) {
    out_.walls = walls;
  }

  std::optional<DiskStructure> read() {
    const int bodies = owners_.bodies;
    for (int k = 0; k < bodies; ++k) {
      if (mass_[k * kDofs] != mass_[k * kDofs + 1]) return {};
    }
    out_.contacts.reserve(to_size(p_.num_contacts()));
    arm_.assign(to_size(bodies), kNaN);
    for (int c = 0; c < p_.num_contacts(); ++c) {
      if (!read_contact(c)) return {};
    }
    out_.bodies.resize(to_size(bodies + out_.walls) + 1);
    for (int k = 0; k < bodies; ++k) {
      DiskStructure::Body& body = out_.bodies[to_size(k)];
      const double arm = arm_[to_size(k)];
      body.inverse_mass = 1 / mass_[k * kDofs];
      if (D == 2 && arm == arm) {
        body.inverse_inertia = arm * arm / mass_[k * kDofs + kDofs - 1];
        body.arm = arm;
      }
    }
    for (int k = bodies; k < out_.surroundings(); ++k) {
      DiskStructure::Body& wall = out_.bodies[to_size(k)];
      wall.inverse_mass = 1 / mass_[owners_.first_row(k)];
      if (D == 2) wall.inverse_inertia = -wall.inverse_mass;
    }
    return std::move(out_);
  }

 private:
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
      if (disk && !close(w.side[1][k], -w.side[0][k], length)) return false;
    }
    if (wall && !(close(std::abs(w.side[1][0]), length, length) && same_normal(contact))) {
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
        if (!close(t.side[0][k], expected, factor)) return false;
        if (body[1] >= 0 && !close(t.side[1][k], disk ? -expected : 0, factor)) return false;
      }
      for (int side = 0; side < (disk ? 2 : 1); ++side) {
        const double arm = -t.side[side][2] / factor;
        double& known = arm_[to_size(body[side])];
        if (known != known) known = arm;
        if (!close(arm, known, std::abs(known))) return false;
      }
    }
    return true;
  }
  /// As of the wall's contacts before.
  bool same_normal(const DiskStructure::Contact& contact) {
    Vec2& normal = wall_normal_[to_size(contact.j - owners_.bodies)];
    const Vec2 n(contact.n[0], contact.n[1]);
    if (normal.isZero(0)) normal = n;
    return (n - normal).lpNorm<Eigen::Infinity>() <= kRounding;
  }

  const ContactProblem& p_;
  const Vector& mass_;
  const RowOwners<kDofs> owners_;
  DiskStructure out_;
  std::vector<double> arm_;        // NaN until a contact has shown it
  std::vector<Vec2> wall_normal_;  // zero until then
};

template <int D>
std::optional<DiskStructure> read_disks(const ContactProblem& p) {
  const Vector mass = p.A.diagonal();
  return read_with_walls(p.num_dofs(), Reader<D>::kDofs,
                         [&](int walls) { return Reader<D>(p, mass, walls).read(); });
}

}  // namespace

std::optional<DiskStructure> disk_structure(const ContactProblem& p) {
  if (!p.has_velocities() || p.dim > 2 || p.rolls() || !is_diagonal(p.A)) return {};
  return p.dim == 1 ? read_disks<1>(p) : read_disks<2>(p);
}

}  // namespace bipot
