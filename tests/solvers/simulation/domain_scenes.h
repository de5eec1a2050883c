#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace bipot {

struct NamedScene {
  std::string name;
  Scene<2> scene;
};

/// What a cut may meet: lattices, disks of several sizes, one disk in touch with everybody, fewer
/// bodies than processes, walls that move, are driven, and carry disks.
std::vector<NamedScene> domain_scenes();

/// Loose disks of three sizes in the left half of a box, which they leave: all of them go from cell
/// to cell.
Scene<2> breaking_dam(int disks);

/// Disks in a box under a lid that a force presses.
Scene<2> pressed_box(int side);

/// 64 spheres in a box.
Scene<3> box_of_spheres();

}  // namespace bipot
