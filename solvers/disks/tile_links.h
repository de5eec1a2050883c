#pragma once

#include "core/base/lists.h"
#include "solvers/disks/contact_tiles.h"

namespace bipot {

/// Bodies that tiles of an order share, for sweeps through the tiles up and down. A sweep up comes
/// to tile 0 first. The tile that a body's row belongs to counts as one with that body.
struct TileLinks {
  int tiles = 0;
  /// Tiles that a sweep up comes to next before tile t, with one of its bodies, and a sweep down.
  /// After these all that a sweep did before to the bodies of t is done.
  Lists<> before, after;
  /// Tiles that a sweep up comes to first and last of all, with one of the bodies of tile t; t may
  /// be one of them.
  Lists<> first, last;
  /// Offsets of rows, one for each line of the cache, that a sweep down uses in tile t but did not
  /// in the tiles just before.
  Lists<unsigned> coming;
};

template <class Bodies>
TileLinks tile_links(const ContactTiles& order, const Bodies& bodies);

}  // namespace bipot
