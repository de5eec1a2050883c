#include "solvers/disks/tile_links.h"

#include <algorithm>
#include <limits>

#include "core/base/types.h"
#include "solvers/disks/disk_kernels.h"

namespace bipot {
namespace {

/// Number of tiles after which a line of the cache may have left a core's own cache.
constexpr int kForgotten = 8;
template <class Bodies>
constexpr int kRowsOfLine = 64 / static_cast<int>(sizeof(RowOfBodies<Bodies>));

/// Calls visit(row) for the bodies of a tile's contacts, from the last batch to the first.
template <class Bodies, class Visit>
void for_rows_down(const ContactTiles& order, const Bodies& bodies, int tile, const Visit& visit) {
  const ContactTiles::Tile& t = order.tiles[to_size(tile)];
  for (int batch = t.last_batch - 1; batch >= t.first_batch; --batch) {
    for (int lane = batch * kLanes; lane < (batch + 1) * kLanes; ++lane) {
      const int c = order.contact[to_size(lane)];
      if (c < 0) continue;
      const auto& contact = bodies.contacts[to_size(c)];
      visit(order.row[to_size(contact.i)]);
      if (contact.j != bodies.surroundings()) visit(order.row[to_size(contact.j)]);
    }
  }
}

/// Adds `other` to the list of `tile` unless it is there. All of a tile come in one go; `seen`: the
/// list that each tile was added to last.
void add_once(int tile, int other, std::vector<std::vector<int>>& lists, std::vector<int>& seen) {
  if (seen[to_size(other)] == tile) return;
  seen[to_size(other)] = tile;
  lists[to_size(tile)].push_back(other);
}

template <class Number>
Lists<Number> joined(const std::vector<std::vector<Number>>& lists) {
  return make_lists<Number>(static_cast<int>(lists.size()), [&](const auto& put) {
    for (std::size_t k = 0; k < lists.size(); ++k) {
      for (const Number number : lists[k]) put(static_cast<int>(k), number);
    }
  });
}

}  // namespace

template <class Bodies>
TileLinks tile_links(const ContactTiles& order, const Bodies& bodies) {
  constexpr int kOfLine = kRowsOfLine<Bodies>;
  const int tiles = static_cast<int>(order.tiles.size());
  // Tiles of a sweep up that come to each row first, and last so far. The tile that a row belongs
  // to counts as the first.
  std::vector<int> begin(to_size(order.num_rows)), latest(begin);
  std::vector<std::vector<int>> before(to_size(tiles)), after(before), first(before), last(before);
  std::vector<int> in_before(to_size(tiles), -1), in_first(in_before), in_last(in_before);
  for (int t = 0; t < tiles; ++t) {
    const ContactTiles::Tile& tile = order.tiles[to_size(t)];
    std::fill(begin.begin() + tile.first_row, begin.begin() + tile.last_row, t);
    std::fill(latest.begin() + tile.first_row, latest.begin() + tile.last_row, t);
    for_rows_down(order, bodies, t, [&](int row) {
      add_once(t, begin[to_size(row)], first, in_first);
      int& previous = latest[to_size(row)];
      if (previous != t) add_once(t, previous, before, in_before);
      previous = t;
    });
    for (const int other : before[to_size(t)]) after[to_size(other)].push_back(t);
  }
  for (int t = 0; t < tiles; ++t) {
    for_rows_down(order, bodies, t,
                  [&](int row) { add_once(t, latest[to_size(row)], last, in_last); });
  }
  std::vector<int> seen(to_size(order.num_rows / kOfLine + 1), std::numeric_limits<int>::max());
  std::vector<std::vector<unsigned>> coming(to_size(tiles));
  for (int t = tiles - 1; t >= 0; --t) {
    for_rows_down(order, bodies, t, [&](int row) {
      int& tile = seen[to_size(row / kOfLine)];
      if (tile - t > kForgotten) {
        coming[to_size(t)].push_back(row_offset<RowOfBodies<Bodies>>(row / kOfLine * kOfLine));
      }
      tile = t;
    });
  }
  return {tiles, joined(before), joined(after), joined(first), joined(last), joined(coming)};
}

template TileLinks tile_links(const ContactTiles&, const DiskStructure&);
template TileLinks tile_links(const ContactTiles&, const SphereStructure&);

}  // namespace bipot
