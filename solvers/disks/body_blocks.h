#pragma once

#include <vector>

#include "core/problem/disk_structure.h"
#include "solvers/disks/contact_tiles.h"
#include "solvers/disks/disk_kernels.h"

namespace bipot {

/// Contacts by bodies, for kernels in which no contact waits for another (the projected gradient).
///
/// The bodies of a tile (contact_tiles.h) stand in blocks of kLanes. A batch of a block holds one
/// contact of each of its bodies, whose rows follow each other: they are read and written as they
/// are, eight at once, and their pushes stay in registers for all batches of the block. Contacts that
/// would leave such a batch half empty are loose: they fill batches with any bodies, soon after.
///
/// A contact belongs to the body whose tile run_wavefront() (wavefront.h) comes to later, from both
/// ends of the packing; within a tile to the one in the later window of kWindowBlocks, within a window
/// to the one that has fewer. There bodies are sorted by the number of their contacts.
struct BodyBlocks {
  ContactTiles tiles;             ///< with kLanes rows of the surroundings in each tile
  std::vector<BodyBlock> blocks;  ///< of one tile after the other, and an end
  std::vector<int> first_block;   ///< of each tile, and the end
};

BodyBlocks block_contacts(const DiskStructure& disks);

}  // namespace bipot
