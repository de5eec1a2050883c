#include "solvers/disks/tile_links.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/problem/delassus.h"
#include "solvers/disks/disk_kernels.h"
#include "tests/support/lattice_problem.h"

namespace bipot {
namespace {

void check_what_is_done_before(const DiskStructure& disks, const ContactTiles& order) {
  const TileLinks links = tile_links(order, disks);
  const int tiles = static_cast<int>(order.tiles.size());
  ASSERT_GT(tiles, 4);
  ASSERT_EQ(links.ready_up.size(), to_size(tiles));
  // Tiles of each body, from the batches.
  std::vector<std::vector<int>> tiles_of(disks.bodies.size());
  for (int t = 0; t < tiles; ++t) {
    const ContactTiles::Tile& tile = order.tiles[to_size(t)];
    for (int lane = tile.first_batch * kLanes; lane < tile.last_batch * kLanes; ++lane) {
      const int c = order.contact[to_size(lane)];
      if (c < 0) continue;
      tiles_of[to_size(disks.contacts[to_size(c)].i)].push_back(t);
      tiles_of[to_size(disks.contacts[to_size(c)].j)].push_back(t);
    }
  }
  bool follows = false;  // before the end
  for (int body = 0; body < disks.surroundings(); ++body) {
    for (const int a : tiles_of[to_size(body)]) {
      for (const int b : tiles_of[to_size(body)]) {
        EXPECT_GT(links.ready_up[to_size(a)], b);
        EXPECT_GT(links.ready_down[to_size(tiles - 1 - a)], tiles - 1 - b);
      }
      follows = follows || links.ready_up[to_size(a)] < tiles;
    }
  }
  EXPECT_TRUE(follows);
}

TEST(TileLinks, AllThatShareABodyAreDoneBefore) {
  const ContactProblem p = triangular_lattice(40, {.tilt = 0.2});
  const DiskStructure disks = *DelassusOperator(p).disks();
  check_what_is_done_before(disks, order_contacts(disks));
  check_what_is_done_before(disks, tile_contacts(disks));
}

void check_lines(const DiskStructure& disks, const ContactTiles& order) {
  const TileLinks links = tile_links(order, disks);
  const int tiles = static_cast<int>(order.tiles.size());
  std::vector<bool> named(to_size(order.num_rows), false);
  for (int t = tiles - 1; t >= 0; --t) {
    for (const unsigned offset : links.coming_to(t)) {
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
