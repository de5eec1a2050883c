#include "solvers/disks/body_blocks.h"

#include "core/base/portable_random.h"
#include "solvers/disks/wavefront.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// A chain of small bodies, each on a floor, and a large one that touches every other of them.
DiskStructure with_hub(int others) {
  DiskStructure out;
  out.bodies.resize(to_size(others) + 2);
  for (int k = 0; k < others; ++k) {
    if (k % 2 == 0) out.contacts.push_back({.i = k, .j = others});
    if (k > 0) out.contacts.push_back({.i = k, .j = k - 1});
    out.contacts.push_back({.i = k, .j = out.surroundings()});
  }
  return out;
}

/// Bodies along a line, each in contact with some of the eight before it.
DiskStructure drawn_chain(int bodies, unsigned seed) {
  PortableRandom draw(seed);
  DiskStructure out;
  out.bodies.resize(to_size(bodies) + 1);
  for (int k = 1; k < bodies; ++k) {
    for (int back = 1; back <= std::min(k, 8); ++back) {
      if (draw.below(4) > 0) continue;
      if (draw.below(2) == 0) {
        out.contacts.push_back({.i = k, .j = k - back});
      } else {
        out.contacts.push_back({.i = k - back, .j = k});
      }
    }
  }
  return out;
}

/// When run_wavefront() comes to a tile.
int turn_of(int tile, int tiles) {
  const int middle = first_upper_tile(tiles);
  return tile < middle ? tile : tiles - 1 - tile + middle;
}

struct RowPlace {
  int tile = -1, window = -1, turn = -1;
};

/// Where the row of each body is.
std::vector<RowPlace> places(const BodyBlocks& blocks, int bodies) {
  const int tiles = static_cast<int>(blocks.tiles.tiles.size());
  std::vector<RowPlace> at_row(to_size(blocks.tiles.num_rows)), out;
  for (int t = 0; t < tiles; ++t) {
    const ContactTiles::Tile& tile = blocks.tiles.tiles[to_size(t)];
    for (int row = tile.first_row; row < tile.last_row - kLanes; ++row) {
      at_row[to_size(row)] = {t, (row - tile.first_row) / (kWindowBlocks * kLanes),
                              turn_of(t, tiles)};
    }
  }
  std::set<int> rows;
  for (int body = 0; body < bodies; ++body) {
    const int row = blocks.tiles.row[to_size(body)];
    EXPECT_TRUE(rows.insert(row).second);
    out.push_back(at_row[to_size(row)]);
    EXPECT_GE(out.back().tile, 0) << "a row of the surroundings";
  }
  return out;
}

void check_blocks(const DiskStructure& disks, const char* what) {
  SCOPED_TRACE(what);
  const BodyBlocks blocks = block_contacts(disks);
  const int bodies = disks.surroundings();
  const std::vector<RowPlace> at = places(blocks, bodies);
  const auto row = [&](int body) { return blocks.tiles.row[to_size(body)]; };
  ASSERT_EQ(blocks.first_block.size(), blocks.tiles.tiles.size() + 1);
  ASSERT_EQ(blocks.first_block.back() + 1, static_cast<int>(blocks.blocks.size()));
  ASSERT_EQ(blocks.blocks.back().first, blocks.tiles.num_batches());

  std::vector<int> seen(disks.contacts.size(), 0);
  const int tiles = static_cast<int>(blocks.tiles.tiles.size());
  for (int t = 0; t < tiles; ++t) {
    const int turn = turn_of(t, tiles);
    for (int b = blocks.first_block[to_size(t)]; b < blocks.first_block[to_size(t) + 1]; ++b) {
      const BodyBlock& block = blocks.blocks[to_size(b)];
      const int first_row = static_cast<int>(block.row / sizeof(BodyRow));
      const int window = (b - blocks.first_block[to_size(t)]) / kWindowBlocks;
      EXPECT_EQ(first_row, blocks.tiles.tiles[to_size(t)].first_row +
                               kLanes * (b - blocks.first_block[to_size(t)]));
      for (int batch = block.first; batch < blocks.blocks[to_size(b) + 1].first; ++batch) {
        const bool loose = batch >= block.loose;
        EXPECT_EQ(blocks.tiles.block_row[to_size(batch)], loose ? -1 : first_row);
        std::set<int> seconds;
        for (int lane = 0; lane < kLanes; ++lane) {
          const int c = blocks.tiles.contact[to_size(batch * kLanes + lane)];
          if (c < 0) continue;
          ++seen[to_size(c)];
          auto [i, j] = std::pair(disks.contacts[to_size(c)].i, disks.contacts[to_size(c)].j);
          if (!loose) {
            const int own = blocks.tiles.first_body_row(batch, lane);
            if (row(i) != own) std::swap(i, j);
            ASSERT_NE(i, bodies);
            EXPECT_EQ(row(i), own);
            if (j != bodies) {
              EXPECT_TRUE(seconds.insert(j).second);
            }
          }
          // The bodies of a contact have begun before: in this tile up to this window, or in the
          // tile before, in the order in which both are taken.
          for (const int body : {i, j}) {
            if (body == bodies) continue;
            const RowPlace& place = at[to_size(body)];
            if (place.tile == t) {
              EXPECT_LE(place.window, window);
            } else {
              EXPECT_EQ(std::abs(place.tile - t), 1);
              EXPECT_LT(place.turn, turn);
            }
          }
          const RowPlace& last = j == bodies || at[to_size(i)].turn > at[to_size(j)].turn
                                     ? at[to_size(i)]
                                     : at[to_size(j)];
          EXPECT_EQ(last.tile, t);
        }
      }
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
}

TEST(BodyBlocks, HoldEveryContactOnceByTheBodyThatComesLater) {
  check_blocks(*disk_structure(triangular_lattice(50)), "triangular");
  check_blocks(*disk_structure(square_lattice(41)), "square");
  check_blocks(*disk_structure(square_lattice(1)), "one disk");
  check_blocks(drawn_chain(900, 1), "drawn");
  check_blocks(drawn_chain(7, 2), "few, drawn");
  check_blocks(with_hub(60), "hub");
}

double filled(const DiskStructure& disks) {
  return static_cast<double>(disks.contacts.size()) /
         (kLanes * block_contacts(disks).tiles.num_batches());
}

TEST(BodyBlocks, BatchesAreNearlyFull) {
  EXPECT_GT(filled(*disk_structure(triangular_lattice(60))), 0.95);
  EXPECT_GT(filled(*disk_structure(square_lattice(60))), 0.9);
  EXPECT_GT(filled(drawn_chain(3000, 3)), 0.8);  // bodies with none to six contacts side by side
  // Contacts of one body fill lanes of their own, not batches.
  EXPECT_GT(filled(with_hub(60)), 0.8);
}

}  // namespace
}  // namespace bipot
