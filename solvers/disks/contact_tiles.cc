#include "solvers/disks/contact_tiles.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/lists.h"
#include "solvers/disks/free_lanes.h"

namespace bipot {
namespace {

/// A tile of fewer bodies costs more to pass on than to process.
constexpr int kTileBodies = 96;

/// The neighbours of each body, without the surroundings.
template <class Bodies>
Lists<> neighbours_of(const Bodies& packed) {
  return make_lists(packed.surroundings(), [&](const auto& put) {
    for (const auto& c : packed.contacts) {
      if (c.j == packed.surroundings()) continue;
      put(c.i, c.j);
      put(c.j, c.i);
    }
  });
}

/// Breadth-first search from `root`, appended to `order`; visited bodies are marked with `round`.
void breadth_first(const Lists<>& neighbours, int root, int round, std::vector<int>& mark,
                   std::vector<int>& order) {
  std::size_t head = order.size();
  order.push_back(root);
  mark[to_size(root)] = round;
  while (head < order.size()) {
    const int body = order[head++];
    const auto first = static_cast<std::ptrdiff_t>(order.size());
    for (const int other : neighbours.of(body)) {
      if (mark[to_size(other)] == round) continue;
      mark[to_size(other)] = round;
      order.push_back(other);
    }
    std::sort(order.begin() + first, order.end(), [&](int a, int b) {
      return std::pair(neighbours.of(a).size(), a) < std::pair(neighbours.of(b).size(), b);
    });
  }
}

/// Largest distance of two bodies in contact.
template <class Bodies>
int bandwidth(const Bodies& packed, const std::vector<int>& row) {
  int widest = 0;
  for (const auto& c : packed.contacts) {
    if (c.j == packed.surroundings()) continue;
    widest = std::max(widest, std::abs(row[to_size(c.i)] - row[to_size(c.j)]));
  }
  return widest;
}

/// Distributes the contacts of a tile over batches: each into the first batch with a free lane that
/// is at least kBatchGap away from all other batches of its two bodies.
class BatchFiller {
 public:
  explicit BatchFiller(std::size_t bodies) : uses_(bodies) {}

  /// Appends the batches of one tile. `rows_of(c)` gives two bodies, -1 for the surroundings.
  template <class RowsOf>
  void fill(int tile, const std::vector<int>& contacts, const RowsOf& rows_of,
            LargeVector<int>& slots) {
    free_.clear();
    links_.clear();
    for (const int c : contacts) {
      const std::pair<int, int> rows = rows_of(c);
      int batch = free_.first(0);
      for (;;) {
        const int wanted =
            std::max(after_uses(tile, rows.first, batch), after_uses(tile, rows.second, batch));
        if (wanted == batch) break;
        batch = free_.first(wanted);
      }
      free_.put(batch, c);
      use(tile, rows.first, batch);
      use(tile, rows.second, batch);
    }
    slots.insert(slots.end(), free_.lanes().begin(), free_.lanes().end());
  }

 private:
  /// The batches of a body, a list through links_; empty in another tile.
  struct Uses {
    int tile = -1, head = -1;
  };
  struct Link {
    int batch, next;
  };
  /// `batch` itself, or the first one far enough after a use of the body.
  int after_uses(int tile, int body, int batch) const {
    if (body < 0 || uses_[to_size(body)].tile != tile) return batch;
    for (int k = uses_[to_size(body)].head; k >= 0; k = links_[to_size(k)].next) {
      const int used = links_[to_size(k)].batch;
      if (std::abs(used - batch) < kBatchGap) return used + kBatchGap;
    }
    return batch;
  }
  void use(int tile, int body, int batch) {
    if (body < 0) return;
    Uses& uses = uses_[to_size(body)];
    if (uses.tile != tile) uses = {tile, -1};
    links_.push_back({batch, uses.head});
    uses.head = static_cast<int>(links_.size()) - 1;
  }
  std::vector<Uses> uses_;
  std::vector<Link> links_;
  FreeLanes free_;
};

/// Interleaves distant parts of the entries: batches then hold contacts that are far apart. Each
/// part reaches its next entry kBatchGap batches later, while the shared bodies are in the cache.
void interleave(std::vector<int>& entries, std::vector<int>& scratch) {
  constexpr std::size_t kPlaces = std::size_t{kBatchGap} * kLanes;
  const std::size_t n = entries.size();
  scratch.clear();
  for (std::size_t step = 0; scratch.size() < n; ++step) {
    for (std::size_t place = 0; place < kPlaces; ++place) {
      const std::size_t at = n * place / kPlaces + step;
      if (at < n * (place + 1) / kPlaces) scratch.push_back(entries[at]);
    }
  }
  entries.swap(scratch);
}

}  // namespace

template <class Bodies>
std::vector<int> reverse_cuthill_mckee(const Bodies& packed) {
  const Lists<> neighbours = neighbours_of(packed);
  const int bodies = packed.surroundings();
  std::vector<int> mark(to_size(bodies), -1), order, trial;
  order.reserve(to_size(bodies));
  int round = 0;
  for (int body = 0; body < bodies; ++body) {
    if (mark[to_size(body)] >= 0) continue;
    // Moves twice to the far end of the component: levels are narrow from there.
    int root = body;
    for (int k = 0; k < 2; ++k) {
      trial.clear();
      breadth_first(neighbours, root, round++, mark, trial);
      root = trial.back();
    }
    breadth_first(neighbours, root, round++, mark, order);
  }
  std::vector<int> row(to_size(bodies));
  for (int k = 0; k < bodies; ++k) row[to_size(order[to_size(k)])] = bodies - 1 - k;
  return row;
}

template <class Bodies>
std::vector<int> body_rows(const Bodies& packed) {
  const int bodies = packed.surroundings();
  std::vector<int> row(to_size(bodies));
  std::iota(row.begin(), row.end(), 0);
  // A square packing in rows has as bandwidth the square root of the number of its bodies.
  if (bandwidth(packed, row) <= 2 * std::sqrt(bodies) + kTileBodies) return row;
  return reverse_cuthill_mckee(packed);
}

template <class Bodies>
std::vector<int> tile_starts(const Bodies& packed, const std::vector<int>& row, int least) {
  const int bodies = packed.surroundings();
  std::vector<int> reach(to_size(bodies), 0);  // of the contacts of each row
  for (const auto& c : packed.contacts) {
    if (c.j == packed.surroundings()) continue;
    const int a = row[to_size(c.i)], b = row[to_size(c.j)];
    int& r = reach[to_size(std::min(a, b))];
    r = std::max({r, a, b});
  }
  std::vector<int> starts{0};
  int reached = 0, next_reached = 0;  // by the tiles before the last one, and including it
  for (int r = 0; r < bodies; ++r) {
    if (r - starts.back() >= least && r > reached) {
      starts.push_back(r);
      reached = next_reached;
    }
    next_reached = std::max(next_reached, reach[to_size(r)]);
  }
  // A short remainder joins the tile before.
  if (starts.size() > 1 && bodies - starts.back() < least / 2) starts.pop_back();
  starts.push_back(bodies);
  return starts;
}

template <class Bodies>
ContactTiles tile_contacts(const Bodies& packed) {
  ContactTiles out;
  const std::vector<int> position = body_rows(packed);
  const std::vector<int> starts = tile_starts(packed, position, kTileBodies);
  const int tiles = static_cast<int>(starts.size()) - 1;
  const int bodies = packed.surroundings();

  // Every tile ends with its own row for the surroundings.
  std::vector<int> tile_of(to_size(bodies));
  for (int t = 0; t < tiles; ++t) {
    for (int r = starts[to_size(t)]; r < starts[to_size(t) + 1]; ++r) tile_of[to_size(r)] = t;
  }
  out.row.resize(to_size(bodies));
  for (int b = 0; b < bodies; ++b) {
    const int at = position[to_size(b)];
    out.row[to_size(b)] = at + tile_of[to_size(at)];
  }
  out.num_rows = bodies + tiles;

  const auto pair_of = [&](int c) {
    const auto& contact = packed.contacts[to_size(c)];
    const int i = position[to_size(contact.i)];
    return std::pair(i, contact.j == bodies ? -1 : position[to_size(contact.j)]);
  };
  std::vector<std::vector<int>> contacts(to_size(tiles));
  for (int c = 0; c < static_cast<int>(packed.contacts.size()); ++c) {
    const auto [i, j] = pair_of(c);
    contacts[to_size(tile_of[to_size(std::max(i, j))])].push_back(c);
  }
  // By the later body, which is in the tile.
  const auto earlier = [&](int a, int b) {
    const auto p = pair_of(a), q = pair_of(b);
    return std::tuple(std::max(p.first, p.second), std::min(p.first, p.second), a) <
           std::tuple(std::max(q.first, q.second), std::min(q.first, q.second), b);
  };
  BatchFiller filler(to_size(bodies));
  std::vector<int> scratch;
  out.contact.reserve(packed.contacts.size() + to_size(tiles) * kLanes);
  for (int t = 0; t < tiles; ++t) {
    ContactTiles::Tile tile;
    tile.first_row = starts[to_size(t)] + t;
    tile.last_row = starts[to_size(t) + 1] + t + 1;
    tile.first_batch = out.num_batches();
    std::sort(contacts[to_size(t)].begin(), contacts[to_size(t)].end(), earlier);
    interleave(contacts[to_size(t)], scratch);
    filler.fill(t, contacts[to_size(t)], pair_of, out.contact);
    tile.last_batch = out.num_batches();
    out.tiles.push_back(tile);
  }
  return out;
}

#define BIPOT_TILES(Bodies)                                                           \
  template ContactTiles tile_contacts(const Bodies&);                                 \
  template std::vector<int> tile_starts(const Bodies&, const std::vector<int>&, int); \
  template std::vector<int> body_rows(const Bodies&);                                 \
  template std::vector<int> reverse_cuthill_mckee(const Bodies&);
BIPOT_TILES(DiskStructure)
BIPOT_TILES(SphereStructure)
#undef BIPOT_TILES

}  // namespace bipot
