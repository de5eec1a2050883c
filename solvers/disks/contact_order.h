#pragma once

#include "solvers/disks/contact_tiles.h"

namespace bipot {

// Orders of contacts for sweeps, which tiles in turn keep. For a DiskStructure or SphereStructure.

/// Batches for sweeps in the order of the rows: by the first body, then the second. In a tile a
/// contact comes at least two batches after all earlier ones that share a body with it. Hence the
/// sweep batch after batch equals the sweep contact after contact. Bodies belong to the tile that
/// uses them first, and may occur in many. In wide packings tiles are parts of strips that can be
/// swept at once (sweep_schedule.h).
template <class Bodies>
ContactTiles order_contacts(const Bodies& bodies);

/// The same in the given order of the contacts, in one tile.
template <class Bodies>
ContactTiles given_order(const Bodies& bodies);

/// Order for symmetric sweeps: the order along the rows if its batches are three quarters full,
/// else that of tile_contacts(). Short rows do not hold eight independent contacts in sequence; the
/// first order would then make nearly empty batches. For spheres the given order, in which moving
/// steps need fewer iterations. In all a body belongs to the tile that uses it first, or to one
/// before.
template <class Bodies>
ContactTiles symmetric_order(const Bodies& bodies);

}  // namespace bipot
