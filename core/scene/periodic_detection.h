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

/// Calls visit(kx, ky) for the images of a body at x that may touch a wall: that nearest to its
/// middle and those around it. The body itself if the scene is not periodic, and at half-planes.
template <int D, class Visit>
void visit_wall_images(const PeriodicCell& cell, const Wall<D>& wall, const Vec<D>& x,
                       const Visit& visit) {
  if (!cell.periodic() || wall.shape == Wall<D>::Shape::kHalfPlane) return visit(0, 0);
  const Vec<D> from = x - (wall.is_circle() ? wall.a : Vec<D>(0.5 * (wall.a + wall.b)));
  const auto [kx, ky] = nearest_corner(cell, from.template head<2>());
  for (int dy = cell.in_y ? -1 : 0; dy <= (cell.in_y ? 1 : 0); ++dy) {
    for (int dx = -1; dx <= 1; ++dx) visit(kx + dx, ky + dy);
  }
}

}  // namespace bipot
