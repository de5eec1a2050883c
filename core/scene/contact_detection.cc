#include "core/scene/contact_detection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <utility>

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

/// Bodies of one size class: cells of this width, and their range in SortedBodies.
struct Level {
  double cell;
  int begin, end;
};

struct CellEntry {
  std::uint64_t key;
  int level, body;

  auto operator<=>(const CellEntry& other) const {
    return std::tie(level, key, body) <=> std::tie(other.level, other.key, other.body);
  }
};

/// Bodies by size class, grid cell (row by row) and number. Places stand in the same order: tests
/// of neighbours read them from one part of memory.
template <int D>
struct SortedBodies {
  struct Place {
    Vec<D> x;
    double radius;
  };
  std::vector<CellEntry> entries;
  std::vector<Place> places;
  std::vector<Level> levels;
};

template <int D>
typename Grid<D>::GridCell cell_of(const Vec<D>& x, double width) {
  constexpr double kMost = Grid<D>::kMaxCell;
  typename Grid<D>::GridCell index;
  for (int k = 0; k < D; ++k) {
    index[to_size(k)] =
        static_cast<std::int64_t>(std::clamp(std::floor(x[k] / width), -kMost, kMost));
  }
  return index;
}

/// How many of the first `count` of two merged lists come from the first list.
std::ptrdiff_t from_first(std::span<const CellEntry> a, std::span<const CellEntry> b,
                          std::ptrdiff_t count) {
  std::ptrdiff_t low = std::max<std::ptrdiff_t>(0, count - std::ssize(b));
  std::ptrdiff_t high = std::min(count, std::ssize(a));
  while (low < high) {
    const std::ptrdiff_t middle = (low + high) / 2;
    if (a[to_size(middle)] < b[to_size(count - middle - 1)]) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

/// Sorts parts on threads and merges them in pairs: all threads take part in each merge.
void sort_entries(std::vector<CellEntry>& entries, int threads) {
  const std::ptrdiff_t size = std::ssize(entries);
  int parts = 1;
  while (2 * parts <= threads && size >= 2 * parts * kPieceItems) parts *= 2;
  const auto bound = [&](int k) { return size * k / parts; };
  run_tasks(threads, parts,
            [&](int k) { std::sort(entries.begin() + bound(k), entries.begin() + bound(k + 1)); });
  std::vector<CellEntry> merged(parts > 1 ? entries.size() : 0);
  for (int width = 1; width < parts; width *= 2) {
    run_tasks(threads, parts, [&](int task) {
      const int left = task / (2 * width) * 2 * width;
      const auto list = [&](int k) {
        return std::span<const CellEntry>(entries.begin() + bound(k),
                                          entries.begin() + bound(k + width));
      };
      const std::span<const CellEntry> a = list(left), b = list(left + width);
      const std::ptrdiff_t first = bound(task) - bound(left), last = bound(task + 1) - bound(left);
      const std::ptrdiff_t a0 = from_first(a, b, first), a1 = from_first(a, b, last);
      std::merge(a.begin() + a0, a.begin() + a1, b.begin() + (first - a0), b.begin() + (last - a1),
                 merged.begin() + bound(task));
    });
    entries.swap(merged);
  }
}

template <int D>
SortedBodies<D> sort_bodies(std::span<const Body<D>> disks, double eta, int threads) {
  SortedBodies<D> sorted;
  const int num_disks = static_cast<int>(disks.size());
  const double smallest = join_pieces(
      threads, num_disks, kInfinity,
      [&](int begin, int end) {
        double least = kInfinity;
        for (int i = begin; i < end; ++i) least = std::min(least, disks[to_size(i)].radius);
        return least;
      },
      [](double& a, double b) { a = std::min(a, b); });
  // Two disks of this class or smaller that touch lie in the same or in adjacent cells.
  const auto width = [&](int level) {
    return 2 * std::ldexp(smallest, level) * (1 + 1e-12) + std::max(eta, 0.0);
  };
  sorted.entries.resize(disks.size());
  run_pieces(threads, num_disks, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Body<D>& disk = disks[to_size(i)];
      int level = 0;  // the least with smallest * 2^level >= radius
      if (std::frexp(disk.radius / smallest, &level) == 0.5) --level;
      sorted.entries[to_size(i)] = {Grid<D>::key(cell_of<D>(disk.x, width(level))), level, i};
    }
  });
  sort_entries(sorted.entries, threads);
  sorted.places.resize(disks.size());
  run_pieces(threads, num_disks, [&](int begin, int end) {
    for (int k = begin; k < end; ++k) {
      const Body<D>& disk = disks[to_size(sorted.entries[to_size(k)].body)];
      sorted.places[to_size(k)] = {disk.x, disk.radius};
    }
  });
  for (int begin = 0; begin < num_disks;) {
    const int level = sorted.entries[to_size(begin)].level;
    const auto beyond = std::partition_point(sorted.entries.begin() + begin, sorted.entries.end(),
                                             [&](const CellEntry& e) { return e.level == level; });
    const int end = static_cast<int>(beyond - sorted.entries.begin());
    sorted.levels.push_back({width(level), begin, end});
    begin = end;
  }
  return sorted;
}

/// True if disks are glued to walls or joined: one test for both, since -1 stands for neither.
template <int D>
bool any_joined(std::span<const Body<D>> disks, int threads) {
  return join_pieces(
      threads, static_cast<int>(disks.size()), false,
      [&](int begin, int end) {
        const auto part = disks.subspan(to_size(begin), to_size(end - begin));
        return std::any_of(part.begin(), part.end(),
                           [](const Body<D>& d) { return (d.wall & d.cluster) != -1; });
      },
      [](bool& a, bool b) { a = a || b; });
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

/// `a` and `b` are the places of the bodies i and j. Inlined by order: it is called for every
/// candidate pair.
template <int D>
[[gnu::always_inline]] inline void test_pair(int i, const auto& a, int j, const auto& b, double eta,
                                             std::vector<Contact<D>>& out) {
  const double radii = a.radius + b.radius;
  const double reach = radii + eta;
  const double distance2 = (a.x - b.x).squaredNorm();
  if (distance2 > reach * reach) return;
  const double distance = std::sqrt(distance2);
  if (distance <= kNoDirection * radii) refuse_coincident<D>(std::min(i, j), std::max(i, j));
  const Vec<D> d = i < j ? a.x - b.x : b.x - a.x;
  out.push_back({std::min(i, j), std::max(i, j), d / distance, distance - radii});
}

/// The order of the contacts of a body: by the other one, then by the normal.
template <int D>
bool earlier(const Contact<D>& a, const Contact<D>& b) {
  if (a.j != b.j) return a.j < b.j;
  return std::lexicographical_compare(a.n.begin(), a.n.end(), b.n.begin(), b.n.end());
}

template <int D>
void test_half_plane(const Body<D>& disk, int i, const Wall<D>& wall, int j, double eta,
                     std::vector<Contact<D>>& out) {
  const double gap = wall.normal.dot(disk.x - wall.a) - disk.radius;
  if (gap <= eta && disk.wall < 0) out.push_back({i, j, wall.normal, gap});
}

/// In each half-plane through its axis a cone is a segment. A sphere touches that of its own
/// half-plane, and from within also the one behind the axis: together they can carry it. On the
/// axis all half-planes are alike, and two planes across each other stand for them.
void test_cone(const Sphere& sphere, int i, const Wall<3>& wall, int j, double eta,
               std::vector<Contact<3>>& out) {
  const double length = (wall.b - wall.a).norm(), least = kNoDirection * sphere.radius;
  const Vec3 axis = (wall.b - wall.a) / length, from = sphere.x - wall.a;
  const Vec3 across = from - from.dot(axis) * axis;
  const double away = across.norm();
  const Vec2 start(0, wall.radius), along(length, wall.radius_b - wall.radius);
  // `r`: of the centre in the half-plane of the direction `way`.
  const auto test = [&](const Vec3& way, double r, bool only_within) {
    const Vec2 place(from.dot(axis), r);
    const double t = std::clamp((place - start).dot(along) / along.squaredNorm(), 0.0, 1.0);
    if (only_within && away >= wall.radius + t * along[1]) return;
    const Vec2 off = place - (start + t * along);
    const double distance = off.norm();
    if (distance - sphere.radius > eta) return;
    if (distance <= least) {
      throw std::invalid_argument(
          fmt::format("the centre of sphere {} lies on the surface of wall '{}', which it touches: "
                      "their contact has no normal",
                      i, wall.name));
    }
    out.push_back({i, j, (off[0] * axis + off[1] * way) / distance, distance - sphere.radius});
  };
  const std::array<Vec3, 3> frame = contact_frame<3>(axis);
  const bool on_axis = away <= least;
  const Vec3 way = on_axis ? frame[1] : Vec3(across / away);
  const std::ptrdiff_t before = std::ssize(out);
  test(way, away, false);
  test(-way, -away, true);
  if (on_axis) {
    test(frame[2], away, true);
    test(-frame[2], -away, true);
  }
  std::sort(out.begin() + before, out.end(), earlier<3>);
}

/// Contacts with the surfaces that only 3D has.
void test_surface(const Disk&, int, const Wall<2>&, int, double, std::vector<Contact<2>>&) {}
void test_surface(const Sphere& sphere, int i, const Wall<3>& wall, int j, double eta,
                  std::vector<Contact<3>>& out) {
  if (wall.shape == Wall<3>::Shape::kCone) return test_cone(sphere, i, wall, j, eta, out);
  wall.mesh->find_contacts(sphere, sphere.x - wall.a, i, j, eta, out);
}

/// The first body of the level whose key is at least this one.
template <int D>
int first_from(const SortedBodies<D>& bodies, const Level& level, std::uint64_t key) {
  const auto begin = bodies.entries.begin();
  return static_cast<int>(std::partition_point(begin + level.begin, begin + level.end,
                                               [&](const CellEntry& e) { return e.key < key; }) -
                          begin);
}

/// Contacts of the bodies [begin, end) of a level with later ones: the rest of their cell, the cell
/// to the right, and three cells of each neighbouring row that comes later. Each pair is met once.
/// All these positions advance together with the bodies.
template <int D>
void find_within(const SortedBodies<D>& bodies, const Level& level, int begin, int end, double eta,
                 std::vector<Contact<D>>& out) {
  out.reserve((D == 2 ? 3 : 6) * to_size(end - begin));
  const auto key = [&](int k) { return bodies.entries[to_size(k)].key; };
  const auto test = [&](int k, int l) {
    const std::size_t a = to_size(k), b = to_size(l);
    test_pair<D>(bodies.entries[a].body, bodies.places[a], bodies.entries[b].body, bodies.places[b],
                 eta, out);
  };
  constexpr auto kRowsAfter = Grid<D>::rows_after();
  std::array<int, kRowsAfter.size()> after;
  for (std::size_t r = 0; r < after.size(); ++r) {
    after[r] = first_from(bodies, level, key(begin) + kRowsAfter[r] - 1);
  }
  for (int k = begin; k < end; ++k) {
    for (int l = k + 1; l < level.end && key(l) <= key(k) + 1; ++l) test(k, l);
    for (std::size_t r = 0; r < after.size(); ++r) {
      int& row = after[r];
      const std::uint64_t first = key(k) + kRowsAfter[r] - 1;
      while (row < level.end && key(row) < first) ++row;
      for (int l = row; l < level.end && key(l) <= first + 2; ++l) test(k, l);
    }
  }
}

/// Contacts of the bodies [begin, end) with larger ones, those of another level.
template <int D>
void find_between(const SortedBodies<D>& bodies, const Level& coarse, int begin, int end,
                  double eta, std::vector<Contact<D>>& out) {
  for (std::size_t k = to_size(begin); k < to_size(end); ++k) {
    // Three adjacent cells of a row; the middle one is given.
    const auto find_in_row = [&](const typename Grid<D>::GridCell& middle) {
      const std::uint64_t first = Grid<D>::key(middle) - 1;
      for (std::size_t l = to_size(first_from(bodies, coarse, first));
           l < to_size(coarse.end) && bodies.entries[l].key <= first + 2; ++l) {
        test_pair<D>(bodies.entries[k].body, bodies.places[k], bodies.entries[l].body,
                     bodies.places[l], eta, out);
      }
    };
    const auto cell = cell_of<D>(bodies.places[k].x, coarse.cell);
    for (std::int64_t row = cell[1] - 1; row <= cell[1] + 1; ++row) {
      auto beside = cell;
      beside[1] = row;
      if constexpr (D == 2) {
        find_in_row(beside);
      } else {
        for (beside[2] = cell[2] - 1; beside[2] <= cell[2] + 1; ++beside[2]) find_in_row(beside);
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
/// counts and moves the contacts of a block of parts, and sorts the lists of a range of i.
template <int D>
std::vector<Contact<D>> sorted(const Found<D>& found, int num_disks, int threads) {
  threads = std::min(threads, 16);  // a table of all bodies each
  const auto each_contact = [&](int block, const auto& f) {
    const auto bound = [&](std::size_t k) { return found.size() * k / to_size(threads); };
    for (std::size_t k = bound(to_size(block)); k < bound(to_size(block) + 1); ++k) {
      for (const Contact<D>& c : found[k]) f(c);
    }
  };
  const auto bound = [&](std::int64_t k) { return static_cast<int>(num_disks * k / threads); };
  std::vector<std::vector<int>> place(to_size(threads));  // by block and i: counts, then the next
  run_tasks(threads, threads, [&](int block) {
    std::vector<int>& count = place[to_size(block)];
    count.assign(to_size(num_disks), 0);
    each_contact(block, [&](const Contact<D>& c) { ++count[to_size(c.i)]; });
  });
  std::vector<int> range_start(to_size(threads) + 1, 0);
  run_tasks(threads, threads, [&](int range) {
    for (const std::vector<int>& count : place) {
      range_start[to_size(range) + 1] +=
          std::accumulate(count.begin() + bound(range), count.begin() + bound(range + 1), 0);
    }
  });
  std::partial_sum(range_start.begin(), range_start.end(), range_start.begin());
  std::vector<int> start(to_size(num_disks) + 1, range_start.back());
  run_tasks(threads, threads, [&](int range) {
    int next = range_start[to_size(range)];
    for (std::size_t i = to_size(bound(range)); i < to_size(bound(range + 1)); ++i) {
      start[i] = next;
      for (std::vector<int>& count : place) next += std::exchange(count[i], next);
    }
  });
  std::vector<Contact<D>> out(to_size(range_start.back()));
  run_tasks(threads, threads, [&](int block) {
    std::vector<int>& next = place[to_size(block)];
    each_contact(block, [&](const Contact<D>& c) { out[to_size(next[to_size(c.i)]++)] = c; });
  });
  run_pieces(threads, num_disks, [&](int first, int last) {
    for (int i = first; i < last; ++i) {
      std::sort(out.begin() + start[to_size(i)], out.begin() + start[to_size(i) + 1], earlier<D>);
    }
  });
  return out;
}

template <int D>
std::vector<Contact<D>> all_contacts(std::span<const Body<D>> disks, std::span<const Wall<D>> walls,
                                     double eta, int threads) {
  Found<D> contacts;
  const SortedBodies<D> bodies = sort_bodies(disks, eta, threads);
  for (std::size_t fine = 0; fine < bodies.levels.size(); ++fine) {
    const Level& level = bodies.levels[fine];
    const auto each_part = [&](const auto& find) {
      collect(threads, level.end - level.begin, contacts, [&](int begin, int end, auto& found) {
        find(level.begin + begin, level.begin + end, found);
      });
    };
    each_part([&](int begin, int end, auto& found) {
      find_within(bodies, level, begin, end, eta, found);
    });
    for (std::size_t coarse = fine + 1; coarse < bodies.levels.size(); ++coarse) {
      each_part([&](int begin, int end, auto& found) {
        find_between(bodies, bodies.levels[coarse], begin, end, eta, found);
      });
    }
  }
  if (any_joined(disks, threads)) {
    run_tasks(threads, static_cast<int>(contacts.size()),
              [&](int k) { sort_joined(disks, contacts[to_size(k)]); });
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
    if (distance > kNoDirection * disk.radius) {
      out.push_back({i, j, d / distance, gap});
    } else if (gap > 0) {  // any direction will do
      out.push_back(
          {i, j, D == 2 ? Vec<D>(Vec<D>::UnitX()) : contact_frame<D>(wall.normal)[1], gap});
    } else {
      throw std::invalid_argument(
          fmt::format("{} {} lies at the centre of wall '{}' and touches it: their contact has no "
                      "normal",
                      kBodyName<D>, i, wall.name));
    }
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
                           double eta, int threads) const {
  if (disks_.empty() || disks.size() != disks_.size() || walls.size() != walls_.size() ||
      eta != eta_) {
    return false;
  }
  const double most2 = 0.25 * skin_ * skin_;
  const bool disks_hold = join_pieces(
      threads, static_cast<int>(disks.size()), true,
      [&](int begin, int end) {
        for (std::size_t k = to_size(begin); k < to_size(end); ++k) {
          if (disks[k].radius != disks_[k].radius) return false;
          if (!((disks[k].x - disks_[k].x).squaredNorm() < most2)) return false;
        }
        return true;
      },
      [](bool& a, bool b) { a = a && b; });
  if (!disks_hold) return false;
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
  if (!hold(disks, walls, eta, threads)) {
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
                test_pair(pair.i, disks[to_size(pair.i)], pair.j, disks[to_size(pair.j)], eta,
                          found);
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
  if (any_joined(disks, threads)) sort_joined(disks, contacts);
  return contacts;
}

template class KeptContacts<2>;
template class KeptContacts<3>;

template std::vector<Contact<2>> detect_contacts<2>(std::span<const Disk>, std::span<const Wall<2>>,
                                                    double, int);
template std::vector<Contact<3>> detect_contacts<3>(std::span<const Sphere>,
                                                    std::span<const Wall<3>>, double, int);

}  // namespace bipot
