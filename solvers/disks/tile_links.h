#pragma once

#include <span>
#include <vector>

#include "core/problem/disk_structure.h"
#include "solvers/disks/contact_tiles.h"

namespace bipot {

/// What the tiles of an order share, for sweeps that go through them up and down.
struct TileLinks {
  /// Tiles that a sweep must have done before the next one may do its tile number k, so that it meets
  /// no body that the one before still comes to. Counted along the way, up and down.
  std::vector<int> ready_up, ready_down;
  /// Row offsets, one for each line of the cache with rows that a sweep down comes to in a tile and
  /// did not meet in the tiles just before. Those of tile t: coming_to(t).
  std::vector<unsigned> coming;
  std::vector<int> coming_start;

  std::span<const unsigned> coming_to(int t) const;
};

TileLinks tile_links(const ContactTiles& order, const DiskStructure& disks);

}  // namespace bipot
