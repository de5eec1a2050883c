#include "solvers/disks/rolling_bodies.h"

#include <cmath>
#include <limits>

namespace bipot {
namespace {

constexpr double kAlmostEqual = 16 * std::numeric_limits<double>::epsilon();

/// The problem of the first `rows` rows of each contact, without velocities.
ContactProblem without_rolling(const ContactProblem& p, int rows) {
  ContactProblem plain{.dim = rows, .A = p.A, .mu = p.mu};
  plain.H.resize(p.num_dofs(), rows * p.num_contacts());
  plain.H.reserve(p.H.nonZeros());
  for (int row = 0; row < rows * p.num_contacts(); ++row) {
    plain.H.startVec(row);
    for (SparseMatrix::InnerIterator it(p.H, row / rows * p.dim + row % rows); it; ++it) {
      plain.H.insertBack(static_cast<int>(it.row()), row) = it.value();
    }
  }
  plain.H.finalize();
  return plain;
}

/// The axis of the moment in a row: in space the tangents, then the normal.
const double* axis_of(const DiskStructure::Contact& /*contact*/, int /*moment*/) {
  static constexpr double kOutOfPlane = 1;
  return &kOutOfPlane;
}
const double* axis_of(const SphereStructure::Contact& contact, int moment) {
  return contact.frame[(moment + 1) % 3];
}

/// True if the rows of moments of a contact are its axes, opposite on the second body, all times
/// one positive factor. kSpins: of a body, its last degrees of freedom.
template <int kSpins, class Contact>
bool turns(const ContactProblem& p, const Contact& contact, bool pair, int c) {
  constexpr int kBody = kSpins == 1 ? 3 : 6;
  double factor = 0;
  for (int k = 0; k < kSpins; ++k) {
    double moment[2][to_size(kSpins)] = {};
    for (SparseMatrix::InnerIterator it(p.H, (c + 1) * p.dim - kSpins + k); it; ++it) {
      if (it.value() == 0) continue;
      const int body = static_cast<int>(it.row()) / kBody;
      const int place = static_cast<int>(it.row()) % kBody - (kBody - kSpins);
      if (place < 0 || (body != contact.i && body != contact.j)) return false;
      moment[body == contact.i ? 0 : 1][place] = it.value();
    }
    const double* const axis = axis_of(contact, k);
    if (k == 0) {
      for (int x = 0; x < kSpins; ++x) factor += axis[x] * moment[0][x];
      if (!(factor > 0)) return false;
    }
    for (int x = 0; x < kSpins; ++x) {
      const double expected = factor * axis[x];
      if (std::abs(moment[0][x] - expected) > kAlmostEqual * factor) return false;
      if (std::abs(moment[1][x] + (pair ? expected : 0)) > kAlmostEqual * factor) return false;
    }
  }
  return true;
}

}  // namespace

template <int D>
std::optional<BodiesOf<D>> rolling_bodies(const ContactProblem& p) {
  constexpr int kSpins = D == kRollingDisks ? 1 : 3;
  if (!p.rolls() || p.dim != kRowsOf<D> || !p.has_velocities()) return {};
  std::optional<BodiesOf<D>> bodies;
  if constexpr (D == kRollingDisks) {
    bodies = disk_structure(without_rolling(p, 2));
  } else {
    bodies = sphere_structure(without_rolling(p, 3));
  }
  if (!bodies || bodies->walls > 0) return {};
  for (int c = 0; c < p.num_contacts(); ++c) {
    const auto& contact = bodies->contacts[to_size(c)];
    const bool pair = contact.j != bodies->surroundings();
    const auto arm = [&](int body) { return bodies->bodies[to_size(body)].arm; };
    if (!(arm(contact.i) > 0) || (pair && !(arm(contact.j) > 0))) return {};
    if (!turns<kSpins>(p, contact, pair, c)) return {};
  }
  return bodies;
}

template std::optional<DiskStructure> rolling_bodies<kRollingDisks>(const ContactProblem&);
template std::optional<SphereStructure> rolling_bodies<kRollingSpheres>(const ContactProblem&);

}  // namespace bipot
