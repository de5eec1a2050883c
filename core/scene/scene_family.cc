#include "core/scene/scene_family.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/base/nearest_name.h"
#include "core/base/portable_random.h"
#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"

namespace bipot {
namespace {

constexpr double kRadius = 0.5;

}  // namespace

std::vector<std::string> family_names() {
  return {"square", "triangular", "diluted", "trapezoid", "pyramid", "random"};
}

Scene<2> make_family_scene(const std::string& family, int side, const FamilyOptions& options) {
  Scene<2> scene;
  scene.title = family + " " + std::to_string(side);
  scene.source = "generated";
  const double tilt = options.tilt_degrees * std::numbers::pi / 180;
  scene.gravity = 9.81 * Vec2(std::sin(tilt), -std::cos(tilt));
  scene.materials = {"default"};
  scene.laws = {{.mu = options.mu, .e_n = options.e_n, .e_t = options.e_t}};
  scene.step = 0.01;
  scene.num_steps = 1;
  scene.contact_distance = 1e-6 * kRadius;

  const Vec2 corner = Vec2::Zero();
  double width = 2 * kRadius * side;
  bool left_wall = true, right_wall = true;
  if (family == "square") {
    scene.bodies = rectangular_lattice(side, side, kRadius, corner);
  } else if (family == "triangular" || family == "trapezoid") {
    scene.bodies = triangular_lattice(side, side, kRadius, corner);
    right_wall = family == "triangular";
  } else if (family == "diluted") {
    // Every disk keeps its place.
    PortableRandom random(options.seed);
    for (const Disk& d : triangular_lattice(side, side, kRadius, corner)) {
      if (random.below(10) != 0) scene.bodies.push_back(d);
    }
  } else if (family == "pyramid") {
    scene.bodies = pyramid(side, kRadius, corner);
    left_wall = right_wall = false;
  } else if (family == "random") {
    width = 2.2 * kRadius * side;
    scene.bodies = random_filling(side * side, {{0.4, 0.25}, {0.5, 0.5}, {0.6, 0.25}}, width, 0.02,
                                  options.seed, corner);
  } else {
    throw std::invalid_argument(unknown_name_message("scene family", family, family_names()));
  }
  PortableRandom random(options.seed);
  for (Disk& d : scene.bodies) give_mass(d, std::pow(options.mass_ratio, random.uniform()));
  scene.walls.push_back(half_space<2>(corner, Vec2(0, 1), "floor"));
  if (left_wall) scene.walls.push_back(half_space<2>(corner, Vec2(1, 0), "left"));
  if (right_wall) {
    scene.walls.push_back(half_space<2>(Vec2(width, 0), Vec2(-1, 0), "right"));
  }
  return scene;
}

}  // namespace bipot
