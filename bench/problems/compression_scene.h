#pragma once

#include <cstdint>

#include "core/scene/scene.h"

namespace bipot {

/// The isotropic compression of Fig. 12 at any size: disks of 0.8, 0.9 and 1.0 mm, loose, in a box
/// of four walls that are pushed inwards. Its defaults are those of
/// data/scenes/isotropic_compression.toml. Smaller samples are similar to it. The sides of the box
/// and the forces scale with the square root of the number of disks, the walls' masses with the
/// number. Pressure, and the time scale of the compression relative to the width, are then those of
/// the large one.
struct CompressionOptions {
  int count = 2470;
  std::uint64_t seed = 1;
  double density = 7800;  ///< [kg/m³]
  double wall_mass = 20;  ///< of a wall of the large sample     [kg]
  double e_t = 1;
  bool smooth_walls = false;  ///< no friction at the walls
};
Scene<2> compression_scene(const CompressionOptions& options);

}  // namespace bipot
