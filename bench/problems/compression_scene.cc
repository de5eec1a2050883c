#include "bench/problems/compression_scene.h"

#include <cmath>
#include <string>
#include <tuple>

#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"

namespace bipot {

Scene<2> compression_scene(const CompressionOptions& options) {
  constexpr double kWidth = 0.1, kForce = 5000, kSpacing = 0.02, kLargest = 1.0e-3;
  constexpr int kCount = 2470;
  const double share = static_cast<double>(options.count) / kCount;
  const double width = kWidth * std::sqrt(share);
  Scene<2> scene{.title = "Isotropic compression, " + std::to_string(options.count) + " disks",
                 .source = "generated",
                 .materials = {"default"}};
  scene.laws = {{.mu = 0.1, .e_n = 0, .e_t = options.e_t}};
  if (options.smooth_walls) {
    const ContactLaw rough = scene.laws[0], smooth = {.mu = 0, .e_n = 0, .e_t = options.e_t};
    scene.materials = {"default", "smooth"};
    scene.laws = {rough, smooth, smooth, smooth};
  }
  scene.bodies = random_filling(options.count, {{0.8e-3, 0.25}, {0.9e-3, 0.5}, {kLargest, 0.25}},
                                width, kSpacing, options.seed, Vec2::Zero());
  for (Disk& d : scene.bodies) {
    give_density(d, options.density);
  }
  // The lid rests on the last row of the filling's grid.
  const double pitch = 2 * kLargest * (1 + kSpacing);
  const int columns = static_cast<int>(std::floor(width / pitch * (1 + 1e-12)));
  const int rows = (options.count + columns - 1) / columns;
  for (const auto& [name, point, normal] :
       {std::tuple{"left", Vec2(0, 0), Vec2(1, 0)},
        std::tuple{"right", Vec2(width, 0), Vec2(-1, 0)},
        std::tuple{"bottom", Vec2(0, 0), Vec2(0, 1)},
        std::tuple{"top", Vec2(0, rows * pitch), Vec2(0, -1)}}) {
    Wall<2> wall{.name = name, .motion = Wall<2>::Motion::kDriven, .a = point};
    wall.normal = wall.direction = normal;
    wall.material = options.smooth_walls ? 1 : 0;
    wall.force = kForce * std::sqrt(share);
    wall.mass = options.wall_mass * share;
    scene.walls.push_back(wall);
  }
  scene.step = 7e-5;
  scene.num_steps = 300;
  scene.contact_distance = 1e-6 * 0.8e-3;
  scene.solver.name = "apgd";
  scene.solver.tol = 1e-2;
  return scene;
}

}  // namespace bipot
