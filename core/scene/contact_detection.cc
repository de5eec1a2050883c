#include "core/scene/contact_detection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <stdexcept>

#include "core/base/parallel.h"
#include "core/scene/triangle_mesh.h"

namespace bipot {
namespace {

/// Cells of a grid, numbered by keys: along x by 1, from row to row by kRow, from layer to layer
/// (in 3D) by kLayer.
template <int D>
struct Grid {
  static constexpr int kBits = D == 2 ? 32 : 21;  // of each coordinate in a key
  static constexpr std::int64_t kOffset = std::int64_t{1} << (kBits - 1);
  static constexpr std::uint64_t kRow = std::uint64_t{1} << kBits;
  static constexpr std::uint64_t kLayer = D == 2 ? 0 : kRow << (kBits % 64);
  // Cells beyond this index share the outermost one: correct, only slower.
  static constexpr double kMaxCell = D == 2 ? 1 << 30 : (1 << 20) - 2;

  using GridCell = std::array<std::int64_t, to_size(D)>;
  static std::uint64_t key(const GridCell& cell) {
    std::uint64_t key = 0;
    for (std::size_t k = cell.size(); k-- > 0;) {
      key =
          (k + 1 < cell.size() ? key << kBits : 0) | static_cast<std::uint64_t>(cell[k] + kOffset);
    }
    return key;
  }

  /// Offsets from a cell to the middle cells of the neighbouring rows that are visited later: those
  /// above, and those in the next layer.
  static constexpr auto rows_after() {
    if constexpr (D == 2) {
      return std::array{kRow};
    } else {
      return std::array{kRow, kLayer - kRow, kLayer, kLayer + kRow};
    }
  }
};

struct CellEntry {
  std::uint64_t key;
  int disk;
};

/// The disks of one size class, sorted by grid cell (row by row).
template <int D>
struct Level {
  double cell = 0;
  std::vector<CellEntry> entries;

  typename Grid<D>::GridCell cell_of(const Vec<D>& x) const {
    constexpr double kMost = Grid<D>::kMaxCell;
    typename Grid<D>::GridCell index;
    for (int k = 0; k < D; ++k) {
      index[to_size(k)] =
          static_cast<std::int64_t>(std::clamp(std::floor(x[k] / cell), -kMost, kMost));
    }
    return index;
  }
};

/// By key, then by disk: parts on threads, which are then merged.
void sort_entries(std::vector<CellEntry>& entries, int threads) {
  const auto earlier = [](const CellEntry& a, const CellEntry& b) {
    return a.key != b.key ? a.key < b.key : a.disk < b.disk;
  };
  const auto size = static_cast<std::ptrdiff_t>(entries.size());
  int parts = 1;
  while (2 * parts <= threads && size >= 2 * parts * kPieceItems) parts *= 2;
  const auto bound = [&](int k) { return entries.begin() + size * k / parts; };
  run_tasks(threads, parts, [&](int k) { std::sort(bound(k), bound(k + 1), earlier); });
  for (int width = 1; width < parts; width *= 2) {
    run_tasks(threads, parts / (2 * width), [&](int k) {
      std::inplace_merge(bound(2 * k * width), bound((2 * k + 1) * width),
                         bound((2 * k + 2) * width), earlier);
    });
  }
}

template <int D>
std::vector<Level<D>> build_levels(std::span<const Body<D>> disks, double eta, int threads) {
  std::vector<Level<D>> levels;
  if (disks.empty()) return levels;
  double smallest = disks[0].radius;
  for (const Body<D>& d : disks) smallest = std::min(smallest, d.radius);
  const int num_disks = static_cast<int>(disks.size());
  std::vector<int> level_of(disks.size());  // smallest * 2^level >= radius
  run_pieces(threads, num_disks, [&](int begin, int end) {
    for (std::size_t i = to_size(begin); i < to_size(end); ++i) {
      int exponent = 0;
      const double mantissa = std::frexp(disks[i].radius / smallest, &exponent);
      level_of[i] = mantissa == 0.5 ? exponent - 1 : exponent;
    }
  });
  std::vector<std::vector<int>> members;
  for (int i = 0; i < num_disks; ++i) {
    const std::size_t level = to_size(level_of[to_size(i)]);
    if (level >= members.size()) members.resize(level + 1);
    members[level].push_back(i);
  }
  for (std::size_t l = 0; l < members.size(); ++l) {
    if (members[l].empty()) continue;
    Level<D> level;
    // Two disks of this class or smaller that touch lie in the same or in adjacent cells.
    level.cell = 2 * std::ldexp(smallest, static_cast<int>(l)) * (1 + 1e-12) + std::max(eta, 0.0);
    level.entries.resize(members[l].size());
    run_pieces(threads, static_cast<int>(members[l].size()), [&](int begin, int end) {
      for (std::size_t k = to_size(begin); k < to_size(end); ++k) {
        const int i = members[l][k];
        level.entries[k] = {Grid<D>::key(level.cell_of(disks[to_size(i)].x)), i};
      }
    });
    sort_entries(level.entries, threads);
    levels.push_back(std::move(level));
  }
  return levels;
}

/// True if disks are glued to walls or joined: one test for both, since -1 stands for neither.
template <int D>
bool any_joined(std::span<const Body<D>> disks) {
  return std::any_of(disks.begin(), disks.end(),
                     [](const Body<D>& d) { return (d.wall & d.cluster) != -1; });
}

/// Sorts pairs of disks: a disk glued to a wall comes second. Pairs of two glued disks and pairs
/// within one cluster are removed.
template <int D>
void sort_joined(std::span<const Body<D>> disks, std::vector<Contact<D>>& contacts) {
  const auto body = [&](int k) -> const Body<D>& { return disks[to_size(k)]; };
  const auto is_pair = [&](const Contact<D>& c) { return to_size(c.j) < disks.size(); };
  std::erase_if(contacts, [&](const Contact<D>& c) {
    if (!is_pair(c)) return false;
    const Body<D>&a = body(c.i), &b = body(c.j);
    return (a.wall >= 0 && b.wall >= 0) || (a.cluster >= 0 && a.cluster == b.cluster);
  });
  for (Contact<D>& c : contacts) {
    if (!is_pair(c) || body(c.i).wall < 0) continue;
    std::swap(c.i, c.j);
    c.n = -c.n;
  }
}

template <int D>
[[noreturn]] void refuse_coincident(int i, int j) {
  throw std::invalid_argument(fmt::format(
      "{}s {} and {} have the same centre: their contact has no normal", kBodyName<D>, i, j));
}

/// Inlined by order: it is called for every candidate pair.
template <int D>
[[gnu::always_inline]] inline void test_pair(std::span<const Body<D>> disks, int i, int j,
                                             double eta, std::vector<Contact<D>>& out) {
  if (i > j) std::swap(i, j);
  const Body<D>&a = disks[to_size(i)], &b = disks[to_size(j)];
  const Vec<D> d = a.x - b.x;
  const double reach = a.radius + b.radius + eta;
  const double distance2 = d.squaredNorm();
  if (distance2 > reach * reach) return;
  const double distance = std::sqrt(distance2);
  if (distance <= kNoDirection * (a.radius + b.radius)) refuse_coincident<D>(i, j);
  out.push_back({i, j, d / distance, distance - (a.radius + b.radius)});
}

template <int D>
void test_half_plane(const Body<D>& disk, int i, const Wall<D>& wall, int j, double eta,
                     std::vector<Contact<D>>& out) {
  const double gap = wall.normal.dot(disk.x - wall.a) - disk.radius;
  if (gap <= eta && disk.wall < 0) out.push_back({i, j, wall.normal, gap});
}

/// A cone touches at one point: that of the half-plane through its axis and the centre.
void test_cone(const Sphere& sphere, int i, const Wall<3>& wall, int j, double eta,
               std::vector<Contact<3>>& out) {
  const double length = (wall.b - wall.a).norm();
  const Vec3 axis = (wall.b - wall.a) / length, from = sphere.x - wall.a;
  const Vec3 across = from - from.dot(axis) * axis;
  const double away = across.norm();
  const Vec2 start(0, wall.radius), along(length, wall.radius_b - wall.radius);
  const Vec2 place(from.dot(axis), away);
  const double t = std::clamp((place - start).dot(along) / along.squaredNorm(), 0.0, 1.0);
  const Vec2 off = place - (start + t * along);
  const double distance = off.norm();
  if (distance - sphere.radius > eta) return;
  const double least = kNoDirection * sphere.radius;
  const bool on_axis = away <= least && wall.radius + t * along[1] > 0;
  if (distance <= least || on_axis) {
    throw std::invalid_argument(fmt::format(
        "the centre of sphere {} lies on the {} of wall '{}', which it touches: their contact has no "
        "normal",
        i, distance <= least ? "surface" : "axis", wall.name));
  }
  Vec3 normal = off[0] * axis;
  if (away > least) normal += off[1] / away * across;
  out.push_back({i, j, normal / distance, distance - sphere.radius});
}

/// Contacts with the surfaces that only 3D has.
void test_surface(const Disk&, int, const Wall<2>&, int, double, std::vector<Contact<2>>&) {}
void test_surface(const Sphere& sphere, int i, const Wall<3>& wall, int j, double eta,
                  std::vector<Contact<3>>& out) {
  if (wall.shape == Wall<3>::Shape::kCone) return test_cone(sphere, i, wall, j, eta, out);
  wall.mesh->find_contacts(sphere, sphere.x - wall.a, i, j, eta, out);
}

using Entries = std::vector<CellEntry>;

Entries::const_iterator first_from(const Entries& entries, std::uint64_t key) {
  return std::lower_bound(entries.begin(), entries.end(), key,
                          [](const CellEntry& e, std::uint64_t k) { return e.key < k; });
}

/// Contacts within a level of the entries [begin, end) with later ones: the rest of their cell, the
/// cell to the right, and three cells of each neighbouring row that comes later. Each pair is met
/// once. All these positions advance together with the entries.
template <int D>
void find_within(std::span<const Body<D>> disks, const Level<D>& level, int begin, int end,
                 double eta, std::vector<Contact<D>>& out) {
  const Entries& entries = level.entries;
  out.reserve((D == 2 ? 3 : 6) * to_size(end - begin));
  constexpr auto kRowsAfter = Grid<D>::rows_after();
  std::array<Entries::const_iterator, kRowsAfter.size()> after;
  for (std::size_t r = 0; r < after.size(); ++r) {
    after[r] = first_from(entries, entries[to_size(begin)].key + kRowsAfter[r] - 1);
  }
  for (int k = begin; k < end; ++k) {
    const CellEntry& entry = entries[to_size(k)];
    for (auto it = entries.begin() + k + 1; it != entries.end() && it->key <= entry.key + 1; ++it) {
      test_pair<D>(disks, entry.disk, it->disk, eta, out);
    }
    for (std::size_t r = 0; r < after.size(); ++r) {
      auto& row = after[r];
      const std::uint64_t first = entry.key + kRowsAfter[r] - 1;
      while (row != entries.end() && row->key < first) ++row;
      for (auto it = row; it != entries.end() && it->key <= first + 2; ++it) {
        test_pair<D>(disks, entry.disk, it->disk, eta, out);
      }
    }
  }
}

/// Contacts of a disk with the entries of three adjacent cells of a row; `cell` is the middle one.
template <int D>
void find_in_row(std::span<const Body<D>> disks, int disk, const Level<D>& coarse,
                 typename Grid<D>::GridCell cell, double eta, std::vector<Contact<D>>& out) {
  const std::uint64_t middle = Grid<D>::key(cell);
  auto it = first_from(coarse.entries, middle - 1);
  for (; it != coarse.entries.end() && it->key <= middle + 1; ++it) {
    test_pair<D>(disks, disk, it->disk, eta, out);
  }
}

/// Contacts of the entries [begin, end) of a level with the larger disks of another.
template <int D>
void find_between(std::span<const Body<D>> disks, const Level<D>& fine, const Level<D>& coarse,
                  int begin, int end, double eta, std::vector<Contact<D>>& out) {
  for (int k = begin; k < end; ++k) {
    const int disk = fine.entries[to_size(k)].disk;
    const auto cell = coarse.cell_of(disks[to_size(disk)].x);
    for (std::int64_t row = cell[1] - 1; row <= cell[1] + 1; ++row) {
      auto beside = cell;
      beside[1] = row;
      if constexpr (D == 2) {
        find_in_row<D>(disks, disk, coarse, beside, eta, out);
      } else {
        for (beside[2] = cell[2] - 1; beside[2] <= cell[2] + 1; ++beside[2]) {
          find_in_row<D>(disks, disk, coarse, beside, eta, out);
        }
      }
    }
  }
}

/// Contacts that threads found, in parts.
template <int D>
using Found = std::vector<std::vector<Contact<D>>>;

/// Calls find(begin, end, found) for parts of the items, on threads. Appends the results in the
/// order of the parts.
template <int D, class Find>
void collect(int threads, int items, Found<D>& found, const Find& find) {
  const std::size_t first = found.size();
  found.resize(first + to_size((items + kPieceItems - 1) / kPieceItems));
  run_pieces(threads, items, [&](int begin, int end) {
    std::vector<Contact<D>>& piece = found[first + to_size(begin / kPieceItems)];
    find(begin, end, piece);
  });
}

/// Sorts by i, then by j: a counting sort into the lists of each i, which are short. Each thread
/// makes the lists of a range of i.
template <int D>
std::vector<Contact<D>> sorted(const Found<D>& found, int num_disks, int threads) {
  std::vector<int> start(to_size(num_disks) + 1, 0);
  const auto each_range = [&](const auto& f) {
    run_tasks(threads, threads, [&](int k) {
      const auto bound = [&](std::int64_t at) {
        return static_cast<int>(num_disks * at / threads);
      };
      f(bound(k), bound(k + 1));
    });
  };
  const auto each_contact = [&](int first, int last, const auto& f) {
    for (const std::vector<Contact<D>>& piece : found) {
      for (const Contact<D>& c : piece) {
        if (first <= c.i && c.i < last) f(c);
      }
    }
  };
  each_range([&](int first, int last) {
    each_contact(first, last, [&](const Contact<D>& c) { ++start[to_size(c.i) + 1]; });
  });
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<int> next(start.begin(), start.end() - 1);
  std::vector<Contact<D>> out(to_size(start.back()));
  each_range([&](int first, int last) {
    each_contact(first, last, [&](const Contact<D>& c) { out[to_size(next[to_size(c.i)]++)] = c; });
    for (int i = first; i < last; ++i) {
      std::sort(out.begin() + start[to_size(i)], out.begin() + start[to_size(i) + 1],
                [](const Contact<D>& a, const Contact<D>& b) {
                  if (a.j != b.j) return a.j < b.j;
                  return std::lexicographical_compare(a.n.begin(), a.n.end(), b.n.begin(),
                                                      b.n.end());
                });
    }
  });
  return out;
}

template <int D>
std::vector<Contact<D>> all_contacts(std::span<const Body<D>> disks, std::span<const Wall<D>> walls,
                                     double eta, int threads) {
  Found<D> contacts;
  const std::vector<Level<D>> levels = build_levels(disks, eta, threads);
  for (std::size_t fine = 0; fine < levels.size(); ++fine) {
    const int entries = static_cast<int>(levels[fine].entries.size());
    collect(threads, entries, contacts, [&](int begin, int end, auto& found) {
      find_within(disks, levels[fine], begin, end, eta, found);
    });
    for (std::size_t coarse = fine + 1; coarse < levels.size(); ++coarse) {
      collect(threads, entries, contacts, [&](int begin, int end, auto& found) {
        find_between(disks, levels[fine], levels[coarse], begin, end, eta, found);
      });
    }
  }
  if (any_joined(disks)) {
    for (std::vector<Contact<D>>& piece : contacts) sort_joined(disks, piece);
  }
  const int num_disks = static_cast<int>(disks.size());
  for (int w = 0; w < static_cast<int>(walls.size()); ++w) {
    const Wall<D>& wall = walls[to_size(w)];
    if (!wall.present) continue;
    collect(threads, num_disks, contacts, [&](int begin, int end, auto& found) {
      for (int i = begin; i < end; ++i) {
        const Body<D>& disk = disks[to_size(i)];
        if (wall.shape == Wall<D>::Shape::kHalfPlane) {
          test_half_plane<D>(disk, i, wall, num_disks + w, eta, found);
        } else {
          find_wall_contact<D>(disk, i, wall, num_disks + w, eta, found);
        }
      }
    });
  }
  return sorted(contacts, num_disks, threads);
}

}  // namespace

template <int D>
void find_wall_contact(const Body<D>& disk, int i, const Wall<D>& wall, int j, double eta,
                       std::vector<Contact<D>>& out) {
  if (disk.wall >= 0) return;
  if (wall.shape == Wall<D>::Shape::kHalfPlane) {
    test_half_plane<D>(disk, i, wall, j, eta, out);
    return;
  }
  if (wall.is_circle()) {
    const bool hollow = wall.shape == Wall<D>::Shape::kHollowCircle;
    Vec<D> d = hollow ? Vec<D>(wall.a - disk.x) : Vec<D>(disk.x - wall.a);
    if constexpr (D == 3) d -= d.dot(wall.normal) * wall.normal;
    const double distance = d.norm();
    const double gap = (hollow ? wall.radius - distance : distance - wall.radius) - disk.radius;
    if (gap > eta) return;
    if (distance <= kNoDirection * disk.radius) {
      throw std::invalid_argument(
          fmt::format("{} {} lies at the centre of wall '{}' and touches it: their contact has no "
                      "normal",
                      kBodyName<D>, i, wall.name));
    }
    out.push_back({i, j, d / distance, gap});
    return;
  }
  if (wall.is_surface()) return test_surface(disk, i, wall, j, eta, out);
  const Vec<D> along = wall.b - wall.a;
  const double t = std::clamp((disk.x - wall.a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  const Vec<D> d = disk.x - (wall.a + t * along);
  const double distance = d.norm();
  if (distance - disk.radius > eta) return;
  if (distance <= kNoDirection * disk.radius) {
    throw std::invalid_argument(
        fmt::format("the centre of {} {} lies on wall '{}': their contact has no normal",
                    kBodyName<D>, i, wall.name));
  }
  out.push_back({i, j, d / distance, distance - disk.radius});
}

template <int D>
std::vector<Contact<D>> detect_contacts(std::span<const Body<D>> disks,
                                        std::span<const Wall<D>> walls, double eta, int threads) {
  return all_contacts(disks, walls, eta, threads);
}

template void find_wall_contact(const Disk&, int, const Wall<2>&, int, double,
                                std::vector<Contact<2>>&);
template void find_wall_contact(const Sphere&, int, const Wall<3>&, int, double,
                                std::vector<Contact<3>>&);

namespace {

/// Width of the skin, relative to the smallest radius: wider skins last longer and have more pairs.
constexpr double kSkin = 0.2;
/// A list must serve at least kWorthwhile calls. After one that did not, none is made for kPause
/// calls.
constexpr int kWorthwhile = 3, kPause = 16;

}  // namespace

template <int D>
bool KeptContacts<D>::hold(std::span<const Body<D>> disks, std::span<const Wall<D>> walls,
                           double eta) const {
  if (disks_.empty() || disks.size() != disks_.size() || walls.size() != walls_.size() ||
      eta != eta_) {
    return false;
  }
  const double most2 = 0.25 * skin_ * skin_;
  for (std::size_t k = 0; k < disks.size(); ++k) {
    if (disks[k].radius != disks_[k].radius) return false;
    if (!((disks[k].x - disks_[k].x).squaredNorm() < most2)) return false;
  }
  for (std::size_t k = 0; k < walls.size(); ++k) {
    const Wall<D>&now = walls[k], &then = walls_[k];
    if (now.shape != then.shape || now.normal != then.normal || now.radius != then.radius ||
        now.present != then.present) {
      return false;
    }
    if (!((now.a - then.a).squaredNorm() < most2)) return false;
    if (!((now.b - then.b).squaredNorm() < most2)) return false;
  }
  return true;
}

template <int D>
void KeptContacts<D>::keep(std::span<const Body<D>> disks, std::span<const Wall<D>> walls,
                           double eta, int threads) {
  disks_.clear();  // no list, should the search throw
  double smallest = kInfinity;
  for (const Body<D>& d : disks) smallest = std::min(smallest, d.radius);
  skin_ = kSkin * smallest;
  pairs_.clear();
  for (const Contact<D>& c : all_contacts(disks, walls, eta + skin_, threads)) {
    if (!pairs_.empty() && pairs_.back().i == c.i && pairs_.back().j == c.j) continue;
    pairs_.push_back({c.i, c.j});
  }
  disks_.reserve(disks.size());
  for (const Body<D>& d : disks) disks_.push_back({d.x, d.radius});
  walls_.assign(walls.begin(), walls.end());
  eta_ = eta;
  lasted_ = 0;
}

template <int D>
std::vector<Contact<D>> KeptContacts<D>::operator()(std::span<const Body<D>> disks,
                                                    std::span<const Wall<D>> walls, double eta,
                                                    int threads) {
  if (!hold(disks, walls, eta)) {
    if (!disks_.empty() && lasted_ < kWorthwhile) pause_ = kPause;
    disks_.clear();
    ++searches_;
    if (pause_ > 0 || disks.empty()) {
      if (pause_ > 0) --pause_;
      return all_contacts(disks, walls, eta, threads);
    }
    try {
      keep(disks, walls, eta, threads);
    } catch (const std::invalid_argument&) {
      // A contact without a normal, perhaps one in the skin alone.
      return all_contacts(disks, walls, eta, threads);
    }
  }
  ++lasted_;
  Found<D> found_in_parts;
  const int num_disks = static_cast<int>(disks.size());
  collect(threads, static_cast<int>(pairs_.size()), found_in_parts,
          [&](int begin, int end, std::vector<Contact<D>>& found) {
            found.reserve(to_size(end - begin));
            for (int k = begin; k < end; ++k) {
              const Pair& pair = pairs_[to_size(k)];
              if (pair.j < num_disks) {
                test_pair(disks, pair.i, pair.j, eta, found);
              } else {
                find_wall_contact<D>(disks[to_size(pair.i)], pair.i,
                                     walls[to_size(pair.j - num_disks)], pair.j, eta, found);
              }
            }
          });
  std::size_t total = 0;
  for (const std::vector<Contact<D>>& piece : found_in_parts) total += piece.size();
  std::vector<Contact<D>> contacts;
  contacts.reserve(total);
  for (const std::vector<Contact<D>>& piece : found_in_parts) {
    contacts.insert(contacts.end(), piece.begin(), piece.end());
  }
  if (any_joined(disks)) sort_joined(disks, contacts);
  return contacts;
}

template class KeptContacts<2>;
template class KeptContacts<3>;

template std::vector<Contact<2>> detect_contacts<2>(std::span<const Disk>, std::span<const Wall<2>>,
                                                    double, int);
template std::vector<Contact<3>> detect_contacts<3>(std::span<const Sphere>,
                                                    std::span<const Wall<3>>, double, int);

}  // namespace bipot
