#pragma once

#include <vector>

#include "solvers/disks/contact_tiles.h"
#include "solvers/disks/disk_kernels.h"

namespace bipot {

/// Contacts ordered by bodies, for kernels without order among contacts (the projected gradient).
///
/// The bodies of a tile (contact_tiles.h) form blocks of kLanes. A batch of a block holds one
/// contact of each of its bodies. Their rows are consecutive, hence read and written eight at once,
/// and their impulses stay in registers for all batches of the block. Contacts that would leave
/// such a batch half empty are loose: they fill later batches with any bodies.
///
/// A contact belongs to the body whose tile run_wavefront() (wavefront.h) reaches later, from both
/// ends of the packing. Within a tile it belongs to the body in the later window of kWindowBlocks,
/// within a window to the one with fewer contacts. There bodies are sorted by their number of
/// contacts.
struct BodyBlocks {
  ContactTiles tiles;             ///< with kLanes rows of the surroundings in each tile
  std::vector<BodyBlock> blocks;  ///< tile after tile, and an end
  std::vector<int> first_block;   ///< of each tile, and the end
};

template <class Bodies>
BodyBlocks block_contacts(const Bodies& bodies);

}  // namespace bipot
