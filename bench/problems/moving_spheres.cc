#include "bench/problems/moving_spheres.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/nearest_name.h"
#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"

namespace bipot {
namespace {

struct SphereFamily {
  const char* name;
  int steps;  // for a side of 8
};
constexpr SphereFamily kSphereFamilies[] = {{"pour3d", 350}, {"pipe", 350}, {"shear3d", 500}};
constexpr double kDensity = 1000, kPipe = 1.02;  // kPipe: of the pipe over the box in it

void add_side_walls(Scene<3>& scene, double width) {
  const bool periodic = scene.cell.in_x;
  for (const int axis : {0, 1}) {
    if (axis == 0 && periodic) continue;
    scene.walls.push_back(half_space<3>(Vec3::Zero(), Vec3::Unit(axis)));
    scene.walls.push_back(half_space<3>(width * Vec3::Unit(axis), -Vec3::Unit(axis)));
  }
}

}  // namespace

std::vector<std::string> moving_sphere_names() { return names_of(kSphereFamilies); }

Scene<3> make_moving_spheres(const std::string& name, int side, const FamilyOptions& options) {
  const SphereFamily& family = find_named("moving family", name, kSphereFamilies);
  Scene<3> scene{.title = fmt::format("{} {}", name, side), .source = "generated"};
  const double tilt = options.tilt_degrees * std::numbers::pi / 180;
  scene.gravity = kGravity * Vec3(std::sin(tilt), 0, -std::cos(tilt));
  scene.materials = {"default"};
  scene.laws = {{.mu = options.mu, .e_n = options.e_n, .e_t = options.e_t}};
  scene.step = 0.005;
  scene.num_steps = static_cast<int>(std::lround(family.steps * std::sqrt(side / 8.0)));
  const double width = std::max<double>(side, 2.6);  // two of the largest side by side
  scene.bodies =
      random_spheres(side * side * side, {{0.4, 1.0 / 3}, {0.5, 1.0 / 3}, {0.6, 1.0 / 3}},
                     Vec2(width, width), 0.05, options.seed, Vec3::Zero());
  for (Sphere& sphere : scene.bodies) {
    give_density(sphere, kDensity);
  }
  scene.contact_distance = 1e-6 * smallest_radius(scene);
  scene.walls.push_back(flat_floor<3>());
  if (name == "pipe") {
    Wall<3> pipe;
    pipe.name = "pipe";
    pipe.shape = Wall<3>::Shape::kHollowCircle;
    pipe.a = Vec3(0.5 * width, 0.5 * width, 0);
    pipe.radius = kPipe * width / std::numbers::sqrt2;
    scene.walls.push_back(pipe);
    return scene;
  }
  if (name == "shear3d") {
    scene.cell.in_x = true;
    scene.cell.width.length = width;
    scene.walls.front().belt = Vec3(0.25 * side, 0, 0);
  }
  add_side_walls(scene, width);
  return scene;
}

}  // namespace bipot
