#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/problem/body_rows.h"

namespace bipot {

/// True if the numbers differ by rounding alone, relative to `size`.
inline bool same_to_rounding(double x, double y, double size) {
  return std::abs(x - y) <= 16 * std::numeric_limits<double>::epsilon() * size;
}

/// What readers of DiskStructure and SphereStructure share: masses, driven walls and arms. Of the
/// kDofs rows of a body the first kSpace are translations.
template <class Structure, int kSpace, int kDofs>
class StructureReader {
 public:
  StructureReader(const ContactProblem& p, const Vector& mass, int walls)
      : p_(p),
        owners_{(p.num_dofs() - walls) / kDofs},
        arm_(to_size(owners_.bodies), kNaN),
        mass_(mass),
        wall_normal_(to_size(walls), Vec<kSpace>::Zero()) {
    out_.walls = walls;
  }

 protected:
  /// The structure, if read_contact(c) is true for each contact.
  template <class ReadContact>
  std::optional<Structure> read_all(const ReadContact& read_contact) {
    const int bodies = owners_.bodies;
    for (int k = 0; k < bodies * kDofs; ++k) {
      const int place = k % kDofs;
      if (mass_[k] != mass_[k - place + (place < kSpace ? 0 : kSpace)]) return {};
    }
    out_.contacts.reserve(to_size(p_.num_contacts()));
    for (int c = 0; c < p_.num_contacts(); ++c) {
      if (!read_contact(c)) return {};
    }
    out_.bodies.resize(to_size(bodies + out_.walls) + 1);
    for (int k = 0; k < bodies; ++k) {
      auto& body = out_.bodies[to_size(k)];
      const double arm = arm_[to_size(k)];
      body.inverse_mass = 1 / mass_[k * kDofs];
      if (arm != arm) continue;
      body.inverse_inertia = arm * arm / mass_[k * kDofs + kSpace];
      body.arm = arm;
    }
    for (int k = bodies; k < out_.surroundings(); ++k) {
      auto& wall = out_.bodies[to_size(k)];
      wall.inverse_mass = 1 / mass_[owners_.first_row(k)];
      if (kDofs > kSpace) wall.inverse_inertia = -wall.inverse_mass;
    }
    return std::move(out_);
  }

  /// True if the wall's contacts before had this normal.
  bool same_normal(int wall, const double* n) {
    Vec<kSpace>& known = wall_normal_[to_size(wall - owners_.bodies)];
    const Vec<kSpace> normal = Eigen::Map<const Vec<kSpace>>(n);
    if (known.isZero(0)) known = normal;
    for (int k = 0; k < kSpace; ++k) {
      if (!same_to_rounding(normal[k], known[k], 1)) return false;
    }
    return true;
  }

  const ContactProblem& p_;
  const RowOwners<kDofs> owners_;
  Structure out_;
  std::vector<double> arm_;  // of each body; NaN until a contact has shown it

 private:
  const Vector& mass_;
  std::vector<Vec<kSpace>> wall_normal_;  // zero until a contact has shown it
};

}  // namespace bipot
