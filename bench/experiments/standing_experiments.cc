// A few bodies that stand by friction, or in a hollow, up to a threshold.

#include <cmath>
#include <numbers>
#include <span>

#include "bench/experiments/experiment_scene.h"
#include "bench/experiments/validation_row.h"

namespace bipot {
namespace {

/// Motion after the scene's steps: the largest path of a body over that of free fall.
template <int D>
double motion_of(const Scene<D>& scene, Experiment::Trial& trial) {
  const auto end = run_from_start<D>(scene, trial);
  double way = 0;
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    if (scene.bodies[k].wall >= 0) continue;
    way = std::max(way, (end.bodies[k].x - scene.bodies[k].x).norm());
  }
  return way / (0.5 * kGravity * end.time * end.time);
}

constexpr double kMoves = 1e-4;  // of free fall
const ValidationRow::Margin kBisected = {
    2e-3, "rest is told from motion at 1e-4 of free fall; bisection 1e-4",
    "discretisation: bisection to 1e-4"};

/// A heap of equal bodies on the floor, law 0 between them and law 1 at the floor.
template <int D>
Scene<D> heap(double mu, double mu_floor, const Experiment::Trial& trial) {
  Scene<D> scene = experiment_scene<D>({}, 1e-3, trial);
  scene.materials = {"body", "floor"};
  scene.laws = {{.mu = mu}, {.mu = mu_floor}, {.mu = mu_floor}, {.mu = mu_floor}};
  scene.gravity = -kGravity * Vec<D>::Unit(D - 1);
  if constexpr (D == 2) {
    for (const Vec2& x : {Vec2(-1, 1), Vec2(1, 1), Vec2(0, 1 + std::sqrt(3.0))}) {
      scene.bodies.push_back(round_body<2>(x, 1, 1));
    }
  } else {
    const double out = 2 / std::sqrt(3.0);
    for (int k = 0; k < 3; ++k) {
      const double at = 2 * std::numbers::pi * k / 3;
      scene.bodies.push_back(round_body<3>(Vec3(out * std::cos(at), out * std::sin(at), 1), 1, 1));
    }
    scene.bodies.push_back(round_body<3>(Vec3(0, 0, 1 + 2 * std::sqrt(2.0 / 3)), 1, 1));
  }
  scene.walls = {flat_floor<D>()};
  scene.walls[0].material = 1;
  scene.num_steps = 20;
  return scene;
}

/// The force on a lower body from the top one passes through its floor contact. It therefore leans
/// by half the angle φ of the line of centres from the vertical: mu >= tan(φ/2). The floor carries
/// that load's vertical part, W/n of it, and the body's own W; along the floor W/n tan(φ/2):
/// mu_floor >= tan(φ/2) (1/n)/(1/n + 1).
template <int D, bool kFloor>
void heap_threshold(Experiment& e) {
  const double lean = D == 2 ? std::numbers::pi / 6 : std::acos(std::sqrt(2.0 / 3));
  const double critical = std::tan(lean / 2) / (kFloor ? D + 1 : 1);
  const std::string bodies = D == 2 ? "three disks" : "four spheres";
  e.rows = {ValidationRow(
      std::string(D == 2 ? "three_disks" : "four_spheres") + (kFloor ? "_floor" : "_between"),
      "least μ " + std::string(kFloor ? "at the floor" : "between them") + " at which " + bodies +
          " stand",
      "force through the floor contact (three forces on each lower body), derived in "
      "standing_experiments.cc",
      D == 2 ? (kFloor ? "tan 15° / 3 = 0.0893" : "tan 15° = 0.2679")
             : (kFloor ? "tan(35.264°/2) / 4 = 0.0795" : "tan(35.264°/2) = 0.3178"),
      Expectation::equal(critical), kBisected)};
  e.quick_tols = {10, 1, 1e-1, 1e-2, 1e-4, 1e-8};
  e.run = [critical](Experiment::Trial& trial) {
    Observation found = find_threshold(0.5 * critical, 1.5 * critical, [&](double mu) {
      return motion_of(heap<D>(kFloor ? 1 : mu, kFloor ? mu : 1, trial), trial) <= kMoves;
    });
    trial.seen = {found};
  };
}

/// A disk in the hollow of two equal disks glued to the floor, with tilted gravity. When it is
/// about to leave one of them, the other carries it alone along the line of centres, 30° from the
/// normal, without friction. Beyond, it rolls over with g sin(α - 30°)/(1 + 1/2).
void hollow_threshold(Experiment& e) {
  e.rows = {ValidationRow("rough_wall_hollow",
                          "slope of a rough wall at which a disk leaves the hollow of two of its "
                          "disks [°]",
                          "line of centres, derived in standing_experiments.cc; holds for any μ",
                          "30° for equal disks that touch", Expectation::equal(30), kBisected)};
  e.quick_tols = {10, 1, 1e-1, 1e-2, 1e-4, 1e-8};
  e.run = [](Experiment::Trial& trial) {
    Observation found = find_threshold(-45, -15, [&](double degrees) {
      const double slope = -degrees * std::numbers::pi / 180;
      Scene<2> scene = experiment_scene<2>({.mu = 0.5}, 1e-3, trial);
      scene.gravity = kGravity * Vec2(std::sin(slope), -std::cos(slope));
      for (const Vec2& x : {Vec2(-1, 0), Vec2(1, 0), Vec2(0, std::sqrt(3.0))}) {
        scene.bodies.push_back(round_body<2>(x, 1, 1));
      }
      for (Disk& d : std::span(scene.bodies).first(2)) {
        d.mass = d.inertia = 0;
        d.wall = 0;
      }
      scene.walls = {half_space<2>(Vec2(0, -1), Vec2(0, 1), "rough")};
      scene.num_steps = 20;
      return motion_of(scene, trial) <= kMoves;
    });
    found.value = -found.value;
    trial.seen = {found};
  };
}

}  // namespace

std::vector<Experiment> standing_experiments() {
  return made_by({&heap_threshold<2, false>, &heap_threshold<2, true>, &heap_threshold<3, false>,
                  &heap_threshold<3, true>, &hollow_threshold});
}

}  // namespace bipot
