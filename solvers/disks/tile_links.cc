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

}  // namespace

std::span<const unsigned> TileLinks::coming_to(int t) const {
  const std::size_t first = to_size(coming_start[to_size(t)]);
  return {coming.data() + first, to_size(coming_start[to_size(t) + 1]) - first};
}

template <class Bodies>
TileLinks tile_links(const ContactTiles& order, const Bodies& bodies) {
  constexpr int kOfLine = kRowsOfLine<Bodies>;
  const int tiles = static_cast<int>(order.tiles.size());
  // The tile of a row is the first that uses it.
  std::vector<int> first(to_size(order.num_rows)), last(first.size());
  for (int t = 0; t < tiles; ++t) {
    const ContactTiles::Tile& tile = order.tiles[to_size(t)];
    std::fill(first.begin() + tile.first_row, first.begin() + tile.last_row, t);
    for_rows_down(order, bodies, t, [&](int row) { last[to_size(row)] = t; });
  }
  TileLinks links;
  int ready = 0;
  for (int t = 0; t < tiles; ++t) {
    ready = std::max(ready, t + 1);
    for_rows_down(order, bodies, t,
                  [&](int row) { ready = std::max(ready, last[to_size(row)] + 1); });
    links.ready_up.push_back(ready);
  }
  std::vector<int> seen(to_size(order.num_rows / kOfLine + 1), std::numeric_limits<int>::max());
  std::vector<std::vector<unsigned>> coming(to_size(tiles));
  ready = 0;
  for (int t = tiles - 1; t >= 0; --t) {
    ready = std::max(ready, tiles - t);
    for_rows_down(order, bodies, t, [&](int row) {
      ready = std::max(ready, tiles - first[to_size(row)]);
      int& tile = seen[to_size(row / kOfLine)];
      if (tile - t > kForgotten) {
        coming[to_size(t)].push_back(row_offset<RowOfBodies<Bodies>>(row / kOfLine * kOfLine));
      }
      tile = t;
    });
    links.ready_down.push_back(ready);
  }
  links.coming_start.push_back(0);
  for (const std::vector<unsigned>& lines : coming) {
    links.coming.insert(links.coming.end(), lines.begin(), lines.end());
    links.coming_start.push_back(static_cast<int>(links.coming.size()));
  }
  return links;
}

template TileLinks tile_links(const ContactTiles&, const DiskStructure&);
template TileLinks tile_links(const ContactTiles&, const SphereStructure&);

}  // namespace bipot
