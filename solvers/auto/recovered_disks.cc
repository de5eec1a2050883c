#include "solvers/auto/recovered_disks.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/triplets.h"

namespace bipot {
namespace {

// kSame       1e-7   blocks of one disk agree to this when it is looked for
// kRounding   1e-11  each entry of the recovered W, over the root of the diagonals
constexpr double kSame = 1e-7, kRounding = 1e-11;

/// Off-diagonal block of contacts c and d.
struct Coupling {
  int other = 0;         // d
  double block[2][2]{};  // W_cd, physical
  double light = 0;      // 1/m
  double spin = 0;       // a²/I
  double angle = 0;      // ρ
  int disk = -1;         // the one that they share
};

struct Member {
  int contact = 0;
  double angle = 0;  // seen from the disk, in its own frame
};
struct RecoveredDisk {
  double light = 0, spin = 0;
  std::vector<Member> members;
  double turn = 0;  // of its frame
};

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }
bool alike(double x, double y, double size) { return std::abs(x - y) <= kSame * size; }

class DiskRecovery {
 public:
  explicit DiskRecovery(const ContactProblem& p)
      : p_(p),
        n_(to_size(p.num_contacts())),
        couplings_(n_),
        diagonal_(n_, Mat<2>::Zero()),
        disks_of_(n_) {}

  std::optional<ContactProblem> operator()() {
    if (!read_blocks() || !find_disks() || !add_lone_disks()) return {};
    orient();
    if (!holds()) return {};
    return problem();
  }

 private:
  double scale(Eigen::Index row) const { return p_.row_scale.size() == 0 ? 1 : p_.row_scale[row]; }

  /// Blocks in physical variables. False: one is not that of a disk.
  bool read_blocks() {
    for (std::size_t c = 0; c < n_; ++c) {
      std::vector<Coupling>& row = couplings_[c];
      for (int k = 0; k < 2; ++k) {
        const auto i = static_cast<Eigen::Index>(2 * c) + k;
        for (SparseRows::InnerIterator it(p_.W, i); it; ++it) {
          const int other = static_cast<int>(it.col()) / 2;
          const double value = it.value() * scale(i) * scale(it.col());
          if (value == 0) continue;
          if (to_size(other) == c) {
            diagonal_[c](k, it.col() % 2) = value;
            continue;
          }
          auto at = place_of(row, other);
          if (at == row.end() || at->other != other) {
            at = row.insert(at, Coupling());
            at->other = other;
          }
          at->block[k][it.col() % 2] = value;
        }
      }
      for (Coupling& a : row) {
        const double sine = 0.5 * (a.block[1][0] - a.block[0][1]);
        a.light = std::hypot(a.block[0][0], sine);
        a.spin = a.block[1][1] - a.block[0][0];
        a.angle = std::atan2(sine, a.block[0][0]);
        const double rest = a.block[1][0] + a.block[0][1];
        if (!(a.light > 0) || !alike(rest, 0, a.light) || a.spin < -kSame * a.light) return false;
      }
    }
    return true;
  }

  static std::vector<Coupling>::iterator place_of(std::vector<Coupling>& row, int other) {
    return std::lower_bound(row.begin(), row.end(), other,
                            [](const Coupling& a, int b) { return a.other < b; });
  }
  Coupling* find(int c, int d) {
    std::vector<Coupling>& row = couplings_[to_size(c)];
    const auto at = place_of(row, d);
    return at != row.end() && at->other == d ? &*at : nullptr;
  }

  static bool same_disk(const Coupling& a, const Coupling& b) {
    const double size = a.light + std::abs(a.spin);
    return alike(a.light, b.light, size) && alike(a.spin, b.spin, size);
  }

  bool find_disks() {
    for (std::size_t c = 0; c < n_; ++c) {
      for (const Coupling& first : couplings_[c]) {
        if (first.disk >= 0) continue;
        RecoveredDisk disk{first.light, std::max(first.spin, 0.0), {}, 0};
        disk.members = {{static_cast<int>(c), 0}, {first.other, first.angle}};
        for (const Coupling& next : couplings_[c]) {
          if (&next == &first || next.disk >= 0 || !same_disk(first, next)) continue;
          const Coupling* between = find(first.other, next.other);
          if (between == nullptr || between->disk >= 0 || !same_disk(first, *between)) continue;
          if (!alike(wrapped(first.angle + between->angle - next.angle), 0, 1)) continue;
          disk.members.push_back({next.other, next.angle});
        }
        if (!settle(disk)) return false;
      }
    }
    return true;
  }

  /// Gives the blocks between its members to the disk. False: one is missing or taken.
  bool settle(const RecoveredDisk& disk) {
    const int number = static_cast<int>(disks_.size());
    for (const Member& a : disk.members) {
      std::vector<int>& disks = disks_of_[to_size(a.contact)];
      disks.push_back(number);
      if (disks.size() > 2) return false;
      for (const Member& b : disk.members) {
        if (a.contact == b.contact) continue;
        Coupling* between = find(a.contact, b.contact);
        if (between == nullptr || between->disk >= 0) return false;
        between->disk = number;
      }
    }
    disks_.push_back(disk);
    return true;
  }

  /// What a diagonal block has beyond its disks.
  std::pair<double, double> rest_of(std::size_t c) const {
    double light = diagonal_[c](0, 0), spin = diagonal_[c](1, 1) - light;
    for (const int k : disks_of_[c]) {
      light -= disks_[to_size(k)].light;
      spin -= disks_[to_size(k)].spin;
    }
    return {light, spin};
  }

  bool add_lone_disks() {
    for (std::size_t c = 0; c < n_; ++c) {
      const auto [light, spin] = rest_of(c);
      const double size = diagonal_[c](0, 0) + diagonal_[c](1, 1);
      if (light > kRounding * size && disks_of_[c].size() < 2) {
        disks_of_[c].push_back(static_cast<int>(disks_.size()));
        disks_.push_back({light, std::max(spin, 0.0), {{static_cast<int>(c), 0}}, 0});
      }
      const auto [left, turned] = rest_of(c);
      const double mixed = std::abs(diagonal_[c](0, 1)) + std::abs(diagonal_[c](1, 0));
      if (!(std::abs(left) + std::abs(turned) + mixed <= 4 * kRounding * size)) return false;
      if (disks_of_[c].empty()) return false;
    }
    return true;
  }

  const Member& member(int disk, int contact) const {
    const std::vector<Member>& members = disks_[to_size(disk)].members;
    return *std::find_if(members.begin(), members.end(),
                         [&](const Member& m) { return m.contact == contact; });
  }

  /// Turns the frames of the disks, one after the other along their contacts, so that both disks of
  /// a contact see it from opposite sides.
  void orient() {
    std::vector<bool> done(disks_.size(), false);
    std::vector<int> queue;
    for (std::size_t first = 0; first < disks_.size(); ++first) {
      if (done[first]) continue;
      done[first] = true;
      queue.assign(1, static_cast<int>(first));
      for (std::size_t k = 0; k < queue.size(); ++k) {
        const RecoveredDisk& from = disks_[to_size(queue[k])];
        for (const Member& m : from.members) {
          for (const int other : disks_of_[to_size(m.contact)]) {
            if (done[to_size(other)]) continue;
            done[to_size(other)] = true;
            disks_[to_size(other)].turn =
                wrapped(from.turn + m.angle + std::numbers::pi - member(other, m.contact).angle);
            queue.push_back(other);
          }
        }
      }
    }
    normals_.resize(n_);
    for (std::size_t c = 0; c < n_; ++c) {
      const int disk = disks_of_[c].front();
      const double angle = disks_[to_size(disk)].turn + member(disk, static_cast<int>(c)).angle;
      normals_[c] = Vec2(std::cos(angle), std::sin(angle));
    }
  }

  /// True if the blocks of these disks are those of W, to rounding.
  bool holds() const {
    for (std::size_t c = 0; c < n_; ++c) {
      for (const Coupling& a : couplings_[c]) {
        const auto d = to_size(a.other);
        const RecoveredDisk& disk = disks_[to_size(a.disk)];
        const bool same_side = (disks_of_[c].front() == a.disk) == (disks_of_[d].front() == a.disk);
        const double light = same_side ? disk.light : -disk.light;
        const double cosine = normals_[c].dot(normals_[d]);
        const double sine = normals_[c].x() * normals_[d].y() - normals_[c].y() * normals_[d].x();
        const double size = std::sqrt(diagonal_[c](0, 0) * diagonal_[d](0, 0)) +
                            std::sqrt(diagonal_[c](1, 1) * diagonal_[d](1, 1));
        const double error = std::abs(a.block[0][0] - light * cosine) +
                             std::abs(a.block[0][1] + light * sine) +
                             std::abs(a.block[1][0] - light * sine) +
                             std::abs(a.block[1][1] - light * cosine - disk.spin);
        if (!(error <= kRounding * size)) return false;
      }
    }
    return true;
  }

  ContactProblem problem() const {
    const auto dofs = static_cast<Eigen::Index>(3 * disks_.size());
    ContactProblem made = p_;
    made.W = SparseRows();
    made.v_free = Vector::Zero(dofs);
    Triplets mass, map;
    for (std::size_t k = 0; k < disks_.size(); ++k) {
      const int at = static_cast<int>(3 * k);
      const RecoveredDisk& disk = disks_[k];
      const double inertia = turns(disk) ? 1 / disk.spin : 1;
      for (const auto& [i, value] :
           {std::pair{0, 1 / disk.light}, {1, 1 / disk.light}, {2, inertia}}) {
        mass.emplace_back(at + i, at + i, value);
      }
    }
    for (std::size_t c = 0; c < n_; ++c) {
      const Vec2 n = normals_[c], t(-n.y(), n.x());
      const int row = static_cast<int>(2 * c);
      double sign = 1;
      for (const int k : disks_of_[c]) {
        for (int i = 0; i < 2; ++i) {
          map.emplace_back(3 * k + i, row, sign * n[i] / scale(row));
          map.emplace_back(3 * k + i, row + 1, sign * t[i] / scale(row + 1));
        }
        if (turns(disks_[to_size(k)])) map.emplace_back(3 * k + 2, row + 1, -1 / scale(row + 1));
        sign = -1;
      }
    }
    made.A = from_triplets(dofs, dofs, mass);
    made.H = from_triplets(dofs, p_.num_rows(), map);
    return made;
  }
  static bool turns(const RecoveredDisk& disk) { return disk.spin > kRounding * disk.light; }

  const ContactProblem& p_;
  const std::size_t n_;
  std::vector<std::vector<Coupling>> couplings_;
  std::vector<Mat<2>> diagonal_;
  std::vector<std::vector<int>> disks_of_;  // of a contact; the first is the one it pushes along n
  std::vector<RecoveredDisk> disks_;
  std::vector<Vec2> normals_;
};

}  // namespace

std::optional<ContactProblem> recovered_disks(const ContactProblem& p) {
  if (p.dim != 2 || p.has_velocities() || !p.has_delassus() || p.num_contacts() == 0) return {};
  return DiskRecovery(p)();
}

}  // namespace bipot
