#include "core/scene/contact_detection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace bipot {
namespace {

// Cells beyond this index share the outermost one: correct, only slower.
constexpr double kMaxCell = 1 << 30;

struct CellEntry {
  std::uint64_t key;
  int disk;
};

/// The disks of one size class, sorted by grid cell (row by row).
struct Level {
  double cell = 0;
  std::vector<CellEntry> entries;

  std::int64_t index(double x) const {
    return static_cast<std::int64_t>(std::clamp(std::floor(x / cell), -kMaxCell, kMaxCell));
  }
  static std::uint64_t key(std::int64_t column, std::int64_t row) {
    constexpr std::int64_t kOffset = std::int64_t{1} << 31;
    return (static_cast<std::uint64_t>(row + kOffset) << 32) |
           static_cast<std::uint64_t>(column + kOffset);
  }
};

std::vector<Level> build_levels(std::span<const Disk> disks, double eta) {
  std::vector<Level> levels;
  if (disks.empty()) return levels;
  double smallest = disks[0].radius;
  for (const Disk& d : disks) smallest = std::min(smallest, d.radius);
  std::vector<std::vector<int>> members;
  for (int i = 0; i < static_cast<int>(disks.size()); ++i) {
    int exponent = 0;
    const double mantissa = std::frexp(disks[to_size(i)].radius / smallest, &exponent);
    const int level = mantissa == 0.5 ? exponent - 1 : exponent;  // smallest * 2^level >= radius
    if (level >= static_cast<int>(members.size())) members.resize(to_size(level) + 1);
    members[to_size(level)].push_back(i);
  }
  for (std::size_t l = 0; l < members.size(); ++l) {
    if (members[l].empty()) continue;
    Level level;
    // Two disks of this class or smaller that touch lie in the same or in adjacent cells.
    level.cell = 2 * std::ldexp(smallest, static_cast<int>(l)) * (1 + 1e-12) + std::max(eta, 0.0);
    level.entries.reserve(members[l].size());
    for (int i : members[l]) {
      const Vec2& x = disks[to_size(i)].x;
      level.entries.push_back({Level::key(level.index(x[0]), level.index(x[1])), i});
    }
    std::sort(level.entries.begin(), level.entries.end(),
              [](const CellEntry& a, const CellEntry& b) {
                return a.key != b.key ? a.key < b.key : a.disk < b.disk;
              });
    levels.push_back(std::move(level));
  }
  return levels;
}

void test_pair(std::span<const Disk> disks, int i, int j, double eta, std::vector<Contact>& out) {
  if (i > j) std::swap(i, j);
  const Disk &a = disks[to_size(i)], &b = disks[to_size(j)];
  const Vec2 d = a.x - b.x;
  const double reach = a.radius + b.radius + eta;
  const double distance2 = d.squaredNorm();
  if (distance2 > reach * reach) return;
  const double distance = std::sqrt(distance2);
  if (distance == 0) {
    throw std::invalid_argument(
        fmt::format("disks {} and {} have the same centre: their contact has no normal", i, j));
  }
  out.push_back({i, j, d / distance, distance - (a.radius + b.radius)});
}

void test_wall(const Disk& disk, int i, const Wall& wall, int j, double eta,
               std::vector<Contact>& out) {
  if (wall.shape == Wall::Shape::kHalfPlane) {
    const double gap = wall.normal.dot(disk.x - wall.a) - disk.radius;
    if (gap <= eta) out.push_back({i, j, wall.normal, gap});
    return;
  }
  const Vec2 along = wall.b - wall.a;
  const double t = std::clamp((disk.x - wall.a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  const Vec2 d = disk.x - (wall.a + t * along);
  const double distance = d.norm();
  if (distance - disk.radius > eta) return;
  if (distance == 0) {
    throw std::invalid_argument(fmt::format(
        "the centre of disk {} lies on wall '{}': their contact has no normal", i, wall.name));
  }
  out.push_back({i, j, d / distance, distance - disk.radius});
}

}  // namespace

std::vector<Contact> detect_contacts(std::span<const Disk> disks, std::span<const Wall> walls,
                                     double eta) {
  std::vector<Contact> contacts;
  const std::vector<Level> levels = build_levels(disks, eta);
  for (std::size_t fine = 0; fine < levels.size(); ++fine) {
    for (std::size_t coarse = fine; coarse < levels.size(); ++coarse) {
      const Level& target = levels[coarse];
      for (const CellEntry& entry : levels[fine].entries) {
        const Vec2& x = disks[to_size(entry.disk)].x;
        const std::int64_t column = target.index(x[0]), row = target.index(x[1]);
        for (std::int64_t r = row - 1; r <= row + 1; ++r) {
          const std::uint64_t first = Level::key(column - 1, r), last = Level::key(column + 1, r);
          auto it =
              std::lower_bound(target.entries.begin(), target.entries.end(), first,
                               [](const CellEntry& e, std::uint64_t key) { return e.key < key; });
          for (; it != target.entries.end() && it->key <= last; ++it) {
            // Within a level each pair is met twice, between levels once.
            if (fine == coarse && it->disk <= entry.disk) continue;
            test_pair(disks, entry.disk, it->disk, eta, contacts);
          }
        }
      }
    }
  }
  const int num_disks = static_cast<int>(disks.size());
  for (int w = 0; w < static_cast<int>(walls.size()); ++w) {
    for (int i = 0; i < num_disks; ++i) {
      test_wall(disks[to_size(i)], i, walls[to_size(w)], num_disks + w, eta, contacts);
    }
  }
  std::sort(contacts.begin(), contacts.end(),
            [](const Contact& a, const Contact& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; });
  return contacts;
}

}  // namespace bipot
