#pragma once

#include <vector>

#include "core/scene/cell.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// detect_contacts() in a periodic cell: the contact says which image of its body j disk i touches.
/// At most one image of each body is a candidate, so that pairs (i, j) stay unique. The cell must
/// be longer everywhere than two of the largest diameters and twice eta, else
/// std::invalid_argument. In 3D the cell is periodic in x and y alone. Half-planes must lie along
/// it; of segments and circles the image with the smallest gap counts. O(N log N), deterministic
/// for any number of threads.
template <int D>
std::vector<Contact<D>> detect_periodic_contacts(const std::vector<Body<D>>& disks,
                                                 const std::vector<Wall<D>>& walls,
                                                 const PeriodicCell& cell, double eta,
                                                 int threads = 1);

}  // namespace bipot
