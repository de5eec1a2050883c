#include "bench/problems/moving_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/nearest_name.h"
#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"

namespace bipot {
namespace {

constexpr int kSide = 32;  // side of the scenes for which the numbers below hold

struct MovingFamily {
  const char* name;
  double width;  // over the side                                              [m]
  double step;   // [s]
  int steps;
  bool box;
};
constexpr MovingFamily kFamilies[] = {{"pour", 1, 0.005, 600, true},
                                      {"collapse", 0.63, 0.005, 900, false},
                                      {"tilt", 1, 0.005, 700, true},
                                      {"strike", 1, 0.002, 1500, true}};

/// The heavy disk that follows the others.
Disk striker(double side, double width, double height) {
  Disk disk;
  disk.radius = side / 16;
  disk.x = Vec2(0.5 * width, height + 5 * disk.radius);
  disk.v = Vec2(0, -60 * std::sqrt(side / kSide));
  give_density(disk, 5000);
  return disk;
}

}  // namespace

std::vector<std::string> moving_family_names() { return names_of(kFamilies); }

Scene<2> make_moving_scene(const std::string& name, int side, const FamilyOptions& options) {
  const MovingFamily& family = find_named("moving family", name, kFamilies);
  Scene<2> scene{.title = fmt::format("{} {}", name, side), .source = "generated"};
  const bool tilted = name == "tilt";
  const double degrees = tilted && options.tilt_degrees == 0 ? 30 : options.tilt_degrees;
  const double tilt = degrees * std::numbers::pi / 180;
  scene.gravity = 9.81 * Vec2(std::sin(tilt), -std::cos(tilt));
  scene.materials = {"default"};
  scene.laws = {{.mu = options.mu, .e_n = options.e_n, .e_t = options.e_t}};
  scene.step = family.step;
  scene.num_steps =
      static_cast<int>(std::lround(family.steps * std::sqrt(static_cast<double>(side) / kSide)));
  // Room for two of the largest disks side by side.
  const double width = std::max(family.width * side, 2.6);
  scene.bodies = random_filling(side * side, {{0.4, 1.0 / 3}, {0.5, 1.0 / 3}, {0.6, 1.0 / 3}},
                                width, 0.05, options.seed, Vec2::Zero());
  double height = 0;
  for (Disk& disk : scene.bodies) {
    give_density(disk, 1000);
    height = std::max(height, disk.x.y() + disk.radius);
  }
  if (name == "strike") scene.bodies.push_back(striker(side, width, height));
  scene.contact_distance = 1e-6 * smallest_radius(scene);
  scene.walls.push_back(half_space<2>(Vec2::Zero(), Vec2(0, 1), "floor"));
  if (family.box) {
    scene.walls.push_back(half_space<2>(Vec2::Zero(), Vec2(1, 0), "left"));
    scene.walls.push_back(half_space<2>(Vec2(width, 0), Vec2(-1, 0), "right"));
  }
  return scene;
}

}  // namespace bipot
