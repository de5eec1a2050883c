#pragma once

#include <span>
#include <vector>

#include "solvers/disks/contact_tiles.h"

namespace bipot {

/// Bodies that tiles of an order share, for sweeps through the tiles up and down.
struct TileLinks {
  /// Number of tiles that a sweep must have done before the next one may process its tile number k.
  /// It then shares no body with the rest of the sweep before. Counted in the order of the sweep,
  /// up and down.
  std::vector<int> ready_up, ready_down;
  /// Offsets of rows, one for each line of the cache, that a sweep down uses in a tile but did not
  /// in the tiles just before. Those of tile t: coming_to(t).
  std::vector<unsigned> coming;
  std::vector<int> coming_start;

  std::span<const unsigned> coming_to(int t) const;
};

template <class Bodies>
TileLinks tile_links(const ContactTiles& order, const Bodies& bodies);

}  // namespace bipot
