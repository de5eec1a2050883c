#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/problem/disk_structure.h"

namespace bipot {

/// Positions of disks, reconstructed from their contacts: x_i - x_j = (a_i + a_j) n.
struct DiskPositions {
  /// Centre of each body, without the surroundings. Packings that no contact joins are placed side
  /// by side, `apart` between them. [m]
  std::vector<Vec2> centre;
  /// Number of bodies connected with each body.
  std::vector<int> companions;
};

/// Breadth-first search through the contacts between moving disks. Gaps are taken as closed: the
/// positions are approximate to that extent.
DiskPositions disk_positions(const DiskStructure& disks, double apart);

}  // namespace bipot
