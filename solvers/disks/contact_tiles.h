#pragma once

#include <vector>

#include "core/base/execution.h"
#include "core/base/large_pages.h"
#include "core/base/types.h"
#include "core/problem/disk_structure.h"
#include "solvers/disks/disk_kernels.h"

namespace bipot {

/// An order of bodies and contacts for kernels that stream through memory.
///
/// Bodies stand in rows along the contact graph (the given order where it is local already, else
/// reverse Cuthill-McKee). Rows are cut into tiles so that *a contact joins bodies of one tile or of
/// two neighbouring ones*; it belongs to the later. Hence tile t of one iteration and tile t + 2 of
/// the iteration before share no body: they may run at the same time, or one right after the other
/// while the data are in the cache, and every body still sees the same sequence of contacts.
///
/// The contacts of a tile stand in batches whose lanes share no body, from sixteen places that go
/// along it together: there a body does not occur in two batches that follow each other (its
/// velocity would be waited for), but mostly in the next but one, while the cache still has it.
struct ContactTiles {
  struct Tile {
    int first_batch = 0, last_batch = 0;  ///< half open
    int first_row = 0, last_row = 0;      ///< half open; the surroundings have the last ones
  };
  std::vector<Tile> tiles;
  std::vector<int> row;      ///< of each body, the surroundings excluded
  LargeVector<int> contact;  ///< kLanes a batch: the contact in each lane, -1 where there is none
  /// Of each batch, where there are any: the first row of a block whose bodies stand first in its
  /// contacts (body_blocks.h); -1: any bodies.
  std::vector<int> block_row;
  int num_rows = 0;
  int outside_rows = 1;  ///< of each tile: the last ones are the surroundings

  int num_batches() const { return static_cast<int>(contact.size()) / kLanes; }
  /// The row of a block that belongs to a lane, -1: any.
  int first_body_row(int batch, int lane) const {
    const int block = block_row.empty() ? -1 : block_row[to_size(batch)];
    return block < 0 ? -1 : block + kRowOfLane[lane];
  }
};

ContactTiles tile_contacts(const DiskStructure& disks);

/// Batches for sweeps that keep an order, that of the rows: by the first body, then the second. A
/// contact comes at least two batches after all before it that share a body with it, so that batch
/// after batch is the sweep contact after contact. Tiles are pieces of that order here: bodies stand
/// in the tile that comes to them first, and may occur in many.
ContactTiles order_contacts(const DiskStructure& disks);

/// What sweeps forth and back go through: the order along the rows where its batches are three
/// quarters full, else that of tile_contacts(). Where rows are too short for eight to follow each
/// other the first makes a batch of a contact or two: 101 batches of 163 contacts, where the second
/// makes 21. In both a body stands in the tile that comes to it first, or in one before.
ContactTiles symmetric_order(const DiskStructure& disks);

/// First body of every tile, in the order of their rows along the graph, and the number of bodies.
/// `least`: bodies of a tile.
std::vector<int> tile_starts(const DiskStructure& disks, const std::vector<int>& row, int least);

/// Bodies along the graph: as given where that is local already, else reverse Cuthill-McKee.
std::vector<int> body_rows(const DiskStructure& disks);

/// Rows of the bodies along the graph by reverse Cuthill and McKee (1969): breadth first from a body
/// far out, neighbours by their number of neighbours. The order of the bodies breaks ties.
std::vector<int> reverse_cuthill_mckee(const DiskStructure& disks);

}  // namespace bipot
