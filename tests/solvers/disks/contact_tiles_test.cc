#include "solvers/disks/contact_tiles.h"

#include "core/base/portable_random.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// The same packing with its bodies and contacts in a drawn order.
DiskStructure shuffled(const DiskStructure& disks, unsigned seed) {
  PortableRandom draw(seed);
  std::vector<int> place(disks.bodies.size() - 1);
  std::iota(place.begin(), place.end(), 0);
  for (std::size_t k = place.size(); k > 1; --k) {
    std::swap(place[k - 1], place[to_size(draw.below(static_cast<int>(k)))]);
  }
  DiskStructure out = disks;
  for (std::size_t k = 0; k < place.size(); ++k) out.bodies[to_size(place[k])] = disks.bodies[k];
  for (DiskStructure::Contact& c : out.contacts) {
    if (c.j != disks.surroundings()) c.j = place[to_size(c.j)];
    c.i = place[to_size(c.i)];
  }
  for (std::size_t k = out.contacts.size(); k > 1; --k) {
    std::swap(out.contacts[k - 1], out.contacts[to_size(draw.below(static_cast<int>(k)))]);
  }
  return out;
}

/// One heavy body that touches all others, in a chain.
DiskStructure star(int others) {
  DiskStructure out;
  out.bodies.resize(to_size(others) + 2);
  for (int k = 1; k <= others; ++k) {
    out.contacts.push_back({.i = 0, .j = k});
    if (k > 1) out.contacts.push_back({.i = k - 1, .j = k});
    out.contacts.push_back({.i = k, .j = out.surroundings()});
  }
  return out;
}

void check(const DiskStructure& disks, const char* what) {
  SCOPED_TRACE(what);
  const ContactTiles tiles = tile_contacts(disks);
  const int bodies = disks.surroundings();
  std::vector<int> tile_of(to_size(tiles.num_rows), -1);
  for (std::size_t t = 0; t < tiles.tiles.size(); ++t) {
    for (int r = tiles.tiles[t].first_row; r < tiles.tiles[t].last_row; ++r) {
      tile_of[to_size(r)] = static_cast<int>(t);
    }
  }
  ASSERT_EQ(std::count(tile_of.begin(), tile_of.end(), -1), 0);
  // Every body has a row of its own, none of them the row of the surroundings.
  std::set<int> rows(tiles.row.begin(), tiles.row.end());
  ASSERT_EQ(static_cast<int>(rows.size()), bodies);
  for (const ContactTiles::Tile& tile : tiles.tiles) EXPECT_EQ(rows.count(tile.last_row - 1), 0U);

  std::vector<int> seen(disks.contacts.size(), 0);
  for (std::size_t t = 0; t < tiles.tiles.size(); ++t) {
    std::map<int, int> last_batch;  // of each body in this tile
    for (int batch = tiles.tiles[t].first_batch; batch < tiles.tiles[t].last_batch; ++batch) {
      for (int lane = 0; lane < kLanes; ++lane) {
        const int c = tiles.contact[to_size(batch * kLanes + lane)];
        if (c < 0) continue;
        ++seen[to_size(c)];
        int latest = 0;
        for (const int body : {disks.contacts[to_size(c)].i, disks.contacts[to_size(c)].j}) {
          if (body == bodies) continue;
          const int its = tile_of[to_size(tiles.row[to_size(body)])];
          EXPECT_TRUE(its == static_cast<int>(t) || its == static_cast<int>(t) - 1);
          latest = std::max(latest, its);
          const auto before = last_batch.find(body);
          if (before != last_batch.end()) {
            EXPECT_GE(batch - before->second, 2);
          }
          last_batch[body] = batch;
        }
        EXPECT_EQ(latest, static_cast<int>(t));
      }
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
}

TEST(ContactTiles, HoldEveryContactOnceAndJoinNeighboursOnly) {
  const DiskStructure square = *disk_structure(square_lattice(40));
  const DiskStructure triangular = *disk_structure(triangular_lattice(30));
  check(square, "square");
  check(triangular, "triangular");
  check(shuffled(square, 1), "square, shuffled");
  check(shuffled(triangular, 2), "triangular, shuffled");
  check(*disk_structure(square_lattice(1)), "one disk");
  check(star(400), "star");
}

TEST(ContactTiles, AreNearlyFullAndManyOnALattice) {
  const DiskStructure disks = shuffled(*disk_structure(triangular_lattice(60)), 3);
  const ContactTiles tiles = tile_contacts(disks);
  const auto lanes = static_cast<double>(kLanes * tiles.num_batches());
  EXPECT_GT(static_cast<double>(disks.contacts.size()), 0.85 * lanes);
  EXPECT_GT(tiles.tiles.size(), 20U);
}

/// Sixteen batches hold eight contacts of each of sixteen places along the tile, and these the
/// seven bodies around: 112. Drawn from all over the tile, they would hold 190 of its 400.
TEST(ContactTiles, GoAlongTheTileSoThatBodiesStayInTheCache) {
  const DiskStructure disks = *disk_structure(triangular_lattice(200));
  const ContactTiles tiles = tile_contacts(disks);
  constexpr int kWindow = 16;
  int windows = 0;
  std::size_t bodies = 0;
  for (const ContactTiles::Tile& tile : tiles.tiles) {
    if (tile.last_batch - tile.first_batch < 2 * kWindow) continue;
    for (int batch = tile.first_batch; batch + kWindow <= tile.last_batch; batch += kWindow) {
      std::set<int> seen;
      for (int lane = batch * kLanes; lane < (batch + kWindow) * kLanes; ++lane) {
        const int c = tiles.contact[to_size(lane)];
        if (c < 0) continue;
        for (const int body : {disks.contacts[to_size(c)].i, disks.contacts[to_size(c)].j}) {
          if (body != disks.surroundings()) seen.insert(body);
        }
      }
      ++windows;
      bodies += seen.size();
    }
  }
  ASSERT_GT(windows, 100);
  EXPECT_LT(static_cast<double>(bodies) / windows, 125);
}

// Bodies drawn at random are hundreds of rows apart; along the graph a side of the lattice.
TEST(ContactTiles, ReverseCuthillMcKeeFindsTheWidthOfALattice) {
  constexpr int kSide = 30;
  const DiskStructure disks = shuffled(*disk_structure(square_lattice(kSide)), 4);
  const std::vector<int> row = reverse_cuthill_mckee(disks);
  int widest = 0;
  for (const DiskStructure::Contact& c : disks.contacts) {
    if (c.j == disks.surroundings()) continue;
    widest = std::max(widest, std::abs(row[to_size(c.i)] - row[to_size(c.j)]));
  }
  EXPECT_LE(widest, kSide + 1);
}

}  // namespace
}  // namespace bipot
