#include "solvers/disks/tile_links.h"

#include <span>

#include "core/problem/delassus.h"
#include "solvers/disks/contact_order.h"
#include "solvers/disks/disk_kernels.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

bool contains(std::span<const int> list, int item) {
  return std::find(list.begin(), list.end(), item) != list.end();
}

void check_neighbours(const DiskStructure& disks, const ContactTiles& order) {
  const TileLinks links = tile_links(order, disks);
  const int tiles = static_cast<int>(order.tiles.size());
  ASSERT_GT(tiles, 4);
  ASSERT_EQ(links.tiles, tiles);
  // Tiles of each body: that of its row, and those of its contacts from the batches.
  std::vector<std::set<int>> tiles_of(disks.bodies.size());
  for (int t = 0; t < tiles; ++t) {
    const ContactTiles::Tile& tile = order.tiles[to_size(t)];
    for (int body = 0; body < disks.surroundings(); ++body) {
      const int row = order.row[to_size(body)];
      if (row >= tile.first_row && row < tile.last_row) tiles_of[to_size(body)].insert(t);
    }
    for (int lane = tile.first_batch * kLanes; lane < tile.last_batch * kLanes; ++lane) {
      const int c = order.contact[to_size(lane)];
      if (c < 0) continue;
      tiles_of[to_size(disks.contacts[to_size(c)].i)].insert(t);
      tiles_of[to_size(disks.contacts[to_size(c)].j)].insert(t);
    }
  }
  std::size_t needed = 0;
  for (int body = 0; body < disks.surroundings(); ++body) {
    const std::vector<int> uses(tiles_of[to_size(body)].begin(), tiles_of[to_size(body)].end());
    for (std::size_t k = 1; k < uses.size(); ++k, ++needed) {
      EXPECT_TRUE(contains(links.before.of(uses[k]), uses[k - 1]));
      EXPECT_TRUE(contains(links.after.of(uses[k - 1]), uses[k]));
      EXPECT_TRUE(contains(links.first.of(uses[k]), uses.front()));
      EXPECT_TRUE(contains(links.last.of(uses[k - 1]), uses.back()));
    }
  }
  EXPECT_GT(needed, 0u);
  EXPECT_LE(links.before.items.size(), needed) << "without repetition";
}

TEST(TileLinks, NameTheTilesThatComeToABodyNextFirstAndLast) {
  const ContactProblem p = triangular_lattice(40, {.tilt = 0.2});
  const DiskStructure disks = *DelassusOperator(p).disks();
  check_neighbours(disks, order_contacts(disks));
  check_neighbours(disks, tile_contacts(disks));
}

void check_lines(const DiskStructure& disks, const ContactTiles& order) {
  const TileLinks links = tile_links(order, disks);
  const int tiles = static_cast<int>(order.tiles.size());
  std::vector<bool> named(to_size(order.num_rows), false);
  for (int t = tiles - 1; t >= 0; --t) {
    for (const unsigned offset : links.coming.of(t)) {
      EXPECT_EQ(offset % 64, 0u);
      named[offset / sizeof(BodyRow)] = true;
    }
    const ContactTiles::Tile& tile = order.tiles[to_size(t)];
    for (int lane = tile.first_batch * kLanes; lane < tile.last_batch * kLanes; ++lane) {
      const int c = order.contact[to_size(lane)];
      if (c < 0) continue;
      const int row = order.row[to_size(disks.contacts[to_size(c)].i)];
      EXPECT_TRUE(named[to_size(row / 2 * 2)]) << t;
    }
  }
}

TEST(TileLinks, NameEveryLineOfRowsWhereASweepDownFirstComesToIt) {
  const ContactProblem p = triangular_lattice(40, {});
  const DiskStructure disks = *DelassusOperator(p).disks();
  check_lines(disks, order_contacts(disks));
  check_lines(disks, tile_contacts(disks));
}

}  // namespace
}  // namespace bipot
