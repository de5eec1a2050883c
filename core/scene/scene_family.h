#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace bipot {

/// Scenes of one shape and any size, shared by benchmarks and tests. All have disks of radius 0.5 m
/// and mass 1 kg, gravity 9.81 m/s² and h = 0.01 s, and start at rest.
struct FamilyOptions {
  double mu = 0.3;
  double e_n = 0, e_t = 0;
  double tilt_degrees = 0;  ///< gravity is turned by this angle
  double mass_ratio = 1;    ///< masses log-uniform in [1, ratio], seeded
  std::uint64_t seed = 1;
};

/// "square": side x side disks in a box. "triangular": rows of side and side - 1 in a box.
/// "trapezoid": that without its right wall.
/// "diluted": "triangular" without a tenth of the disks, drawn by the seed: an irregular contact
/// network. "pyramid": side rows on a floor. "random": side x side disks of three radii (0.4, 0.5,
/// 0.6 m), loose, in a box. Throws std::invalid_argument for another name.
Scene<2> make_family_scene(const std::string& family, int side, const FamilyOptions& options = {});
std::vector<std::string> family_names();

}  // namespace bipot
