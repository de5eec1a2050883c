#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/problem/disk_structure.h"

namespace bipot {

/// Where disks are, as their contacts tell: x_i - x_j = (a_i + a_j) n.
struct DiskPositions {
  /// Of each body, the surroundings excluded; packings that no contact joins stand beside each
  /// other, `apart` between them.  [m]
  std::vector<Vec2> centre;
  /// Bodies that hang together with this one.
  std::vector<int> companions;
};

/// Breadth first through the contacts between moving disks. Gaps between them are taken as closed: the
/// positions are those of the packing but for these.
DiskPositions disk_positions(const DiskStructure& disks, double apart);

}  // namespace bipot
