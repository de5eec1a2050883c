#include "bench/problems/moving_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/nearest_name.h"
#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"

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

template <int D>
void run_moving_scene(const Scene<D>& scene, const std::vector<int>& steps,
                      const std::function<void(const SceneStep<D>&)>& on_step,
                      const std::function<bool()>& cancelled) {
  if (steps.empty()) return;
  SolverOptions options{
      .tol = kMovingTolerance, .max_iterations = kMovingIterations, .cancelled = cancelled};
  State<D> state = initial_state(scene);
  SceneRunOptions<D> to_last;
  to_last.steps = steps.back();
  to_last.solver = make_step_solver(require_solver("apgd"), options);
  to_last.on_step = [&](const SceneStep<D>& step) {
    const bool wanted = std::binary_search(steps.begin(), steps.end(), step.report.step);
    if (wanted && step.problem.num_contacts() > 0) on_step(step);
    return true;
  };
  to_last.cancelled = options.cancelled;
  const SceneRun<D> done = run_scene(scene, state, to_last);
  if (cancelled()) throw Interrupted();
  if (done.failure) throw *done.failure;
}

template void run_moving_scene<2>(const Scene<2>&, const std::vector<int>&,
                                  const std::function<void(const SceneStep<2>&)>&,
                                  const std::function<bool()>&);
template void run_moving_scene<3>(const Scene<3>&, const std::vector<int>&,
                                  const std::function<void(const SceneStep<3>&)>&,
                                  const std::function<bool()>&);

}  // namespace bipot
