#include "core/scene/contact_detection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <stdexcept>

#include "core/parallel.h"

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

using Entries = std::vector<CellEntry>;

Entries::const_iterator first_from(const Entries& entries, std::uint64_t key) {
  return std::lower_bound(entries.begin(), entries.end(), key,
                          [](const CellEntry& e, std::uint64_t k) { return e.key < k; });
}

/// Contacts within a level of the entries [begin, end) with later ones: the rest of their cell, the
/// cell to the right and the three above. Each pair is met once. Both places that are looked at move
/// on as the entries do.
void find_within(std::span<const Disk> disks, const Level& level, int begin, int end, double eta,
                 std::vector<Contact>& out) {
  const Entries& entries = level.entries;
  constexpr std::uint64_t kNextRow = std::uint64_t{1} << 32;
  auto above = first_from(entries, entries[to_size(begin)].key + kNextRow - 1);
  for (int k = begin; k < end; ++k) {
    const CellEntry& entry = entries[to_size(k)];
    for (auto it = entries.begin() + k + 1; it != entries.end() && it->key <= entry.key + 1; ++it) {
      test_pair(disks, entry.disk, it->disk, eta, out);
    }
    const std::uint64_t first = entry.key + kNextRow - 1;
    while (above != entries.end() && above->key < first) ++above;
    for (auto it = above; it != entries.end() && it->key <= first + 2; ++it) {
      test_pair(disks, entry.disk, it->disk, eta, out);
    }
  }
}

/// Contacts of the entries [begin, end) of a level with the larger disks of another.
void find_between(std::span<const Disk> disks, const Level& fine, const Level& coarse, int begin,
                  int end, double eta, std::vector<Contact>& out) {
  for (int k = begin; k < end; ++k) {
    const int disk = fine.entries[to_size(k)].disk;
    const Vec2& x = disks[to_size(disk)].x;
    const std::int64_t column = coarse.index(x[0]), row = coarse.index(x[1]);
    for (std::int64_t r = row - 1; r <= row + 1; ++r) {
      const std::uint64_t last = Level::key(column + 1, r);
      auto it = first_from(coarse.entries, Level::key(column - 1, r));
      for (; it != coarse.entries.end() && it->key <= last; ++it) {
        test_pair(disks, disk, it->disk, eta, out);
      }
    }
  }
}

/// Calls find(begin, end, found) for pieces of the items, on threads, and appends what the pieces
/// found in their order.
template <class Find>
void collect(int threads, int items, std::vector<Contact>& out, const Find& find) {
  std::vector<std::vector<Contact>> found(to_size((items + kPieceItems - 1) / kPieceItems));
  run_pieces(threads, items, [&](int begin, int end) {
    std::vector<Contact>& piece = found[to_size(begin / kPieceItems)];
    piece.reserve(3 * to_size(end - begin));
    find(begin, end, piece);
  });
  std::size_t total = out.size();
  for (const std::vector<Contact>& piece : found) total += piece.size();
  out.reserve(total);
  for (const std::vector<Contact>& piece : found) out.insert(out.end(), piece.begin(), piece.end());
}

/// By i, then by j: counted into the lists of each i, which are short.
std::vector<Contact> sorted(const std::vector<Contact>& contacts, int num_disks) {
  std::vector<int> start(to_size(num_disks) + 1, 0);
  for (const Contact& c : contacts) ++start[to_size(c.i) + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<int> next(start.begin(), start.end() - 1);
  std::vector<Contact> out(contacts.size());
  for (const Contact& c : contacts) out[to_size(next[to_size(c.i)]++)] = c;
  for (int i = 0; i < num_disks; ++i) {
    std::sort(out.begin() + start[to_size(i)], out.begin() + start[to_size(i) + 1],
              [](const Contact& a, const Contact& b) { return a.j < b.j; });
  }
  return out;
}

}  // namespace

std::vector<Contact> detect_contacts(std::span<const Disk> disks, std::span<const Wall> walls,
                                     double eta, int threads) {
  std::vector<Contact> contacts;
  const std::vector<Level> levels = build_levels(disks, eta);
  for (std::size_t fine = 0; fine < levels.size(); ++fine) {
    const int entries = static_cast<int>(levels[fine].entries.size());
    collect(threads, entries, contacts, [&](int begin, int end, std::vector<Contact>& found) {
      find_within(disks, levels[fine], begin, end, eta, found);
    });
    for (std::size_t coarse = fine + 1; coarse < levels.size(); ++coarse) {
      collect(threads, entries, contacts, [&](int begin, int end, std::vector<Contact>& found) {
        find_between(disks, levels[fine], levels[coarse], begin, end, eta, found);
      });
    }
  }
  const int num_disks = static_cast<int>(disks.size());
  for (int w = 0; w < static_cast<int>(walls.size()); ++w) {
    for (int i = 0; i < num_disks; ++i) {
      test_wall(disks[to_size(i)], i, walls[to_size(w)], num_disks + w, eta, contacts);
    }
  }
  return sorted(contacts, num_disks);
}

}  // namespace bipot
