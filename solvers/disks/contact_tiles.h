#pragma once

#include <type_traits>
#include <vector>

#include "core/base/execution.h"
#include "core/base/large_pages.h"
#include "core/base/types.h"
#include "core/problem/packed_bodies.h"
#include "solvers/disks/disk_kernels.h"

namespace bipot {

/// The rows of a DiskStructure or SphereStructure. The functions below are for both.
template <class Bodies>
using RowOfBodies = std::conditional_t<std::is_same_v<Bodies, SphereStructure>, SphereRow, BodyRow>;

/// An order of bodies and contacts for kernels that stream through memory.
///
/// Bodies stand in rows along the contact graph: in the given order if that is local, else by
/// reverse Cuthill-McKee. Rows are cut into tiles so that *a contact joins bodies of one tile or of
/// two neighbouring ones*; it belongs to the later tile. Hence tile t of one iteration and tile t +
/// 2 of the iteration before share no body. They may run at the same time, or one after the other
/// while the data are in the cache. Every body still sees the same sequence of contacts.
///
/// The contacts of a tile are grouped into batches whose lanes share no body. They come from
/// sixteen positions that move along the tile together. A body never occurs in two consecutive
/// batches, where its velocity would not be ready. It mostly occurs in the next but one, while it
/// is still in the cache.
struct ContactTiles {
  struct Tile {
    int first_batch = 0, last_batch = 0;  ///< half open
    int first_row = 0, last_row = 0;      ///< half open; the surroundings have the last ones
  };
  std::vector<Tile> tiles;
  std::vector<int> row;  ///< of each body, the surroundings excluded
  /// kLanes for each batch: the contact in each lane, -1 if there is none.
  LargeVector<int> contact;
  /// For each batch, if not empty: the first row of a block whose bodies are the first bodies of
  /// its contacts (body_blocks.h); -1: any bodies.
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

template <class Bodies>
ContactTiles tile_contacts(const Bodies& bodies);

/// First body of every tile, in the order of rows along the graph, and the number of bodies.
/// `least`: least number of bodies of a tile.
template <class Bodies>
std::vector<int> tile_starts(const Bodies& bodies, const std::vector<int>& row, int least);

/// Rows of the bodies along the graph: the given order if that is local, else reverse
/// Cuthill-McKee.
template <class Bodies>
std::vector<int> body_rows(const Bodies& bodies);

/// Rows of the bodies along the graph by reverse Cuthill and McKee (1969): breadth first from a
/// body at the far end, neighbours by their number of neighbours. The order of the bodies breaks
/// ties.
template <class Bodies>
std::vector<int> reverse_cuthill_mckee(const Bodies& bodies);

}  // namespace bipot
