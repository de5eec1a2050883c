
#include <cmath>
#include <numbers>

#include "bench/compare/case_parts.h"
#include "core/scene/scene_family.h"

namespace bipot {
namespace {

void drive(Wall<2>& wall, double force) { drive(wall, wall.normal, 1, force); }

/// Rest is a solution: then each driven wall is in equilibrium, Σ s_n = h F on it.
void add_pressed(std::vector<ExtremeCase>& cases, const std::string& name, const std::string& what,
                 const Scene<2>& scene) {
  cases.push_back(
      {.name = name,
       .what = what,
       .known =
           "rest obeys the law, and on each driven wall at rest the normal impulses add up to h F",
       .problem = step_of(scene),
       .true_error = [scene](const Vector& s, const Vector&) {
         double worst = 0;
         for (std::size_t w = 0; w < scene.walls.size(); ++w) {
           if (scene.walls[w].motion != Wall<2>::Motion::kDriven) continue;
           const double push = scene.step * scene.walls[w].force;
           worst = std::max(worst, std::abs(push_on_wall(scene, w, s) / push - 1));
         }
         return worst;
       }});
}

void add_at_rest(std::vector<ExtremeCase>& cases, const std::string& name, const std::string& what,
                 const std::string& known, const Scene<2>& scene) {
  cases.push_back(
      {.name = name,
       .what = what,
       .known = known + "; the error is the motion left, |u| / (h g)",
       .problem = step_of(scene),
       .true_error = [h_g = scene.step * scene.gravity.norm()](const Vector&, const Vector& u) {
         return u.cwiseAbs().maxCoeff() / h_g;
       }});
}

/// Rows of 4, 5, 6, 7, 6, 5, 4 touching disks, pressed by six walls along the normals of the sides.
Scene<2> hexagon() {
  Scene<2> scene = empty_scene(0.3);
  scene.gravity.setZero();
  const double a = 0.5, rise = std::sqrt(3.0) * a;
  for (int row = -3; row <= 3; ++row) {
    const int count = 7 - std::abs(row);
    for (int k = 0; k < count; ++k) {
      scene.bodies.push_back(round_body<2>(Vec2(2 * a * k - a * (count - 1), rise * row), a, 1));
    }
  }
  // Centres of a side lie on a line at the distance 3 rise from the middle.
  const char* names[] = {"w0", "w1", "w2", "w3", "w4", "w5"};
  for (int k = 0; k < 6; ++k) {
    const double angle = std::numbers::pi / 2 + k * std::numbers::pi / 3;
    const Vec2 inward(-std::cos(angle), -std::sin(angle));
    scene.walls.push_back(half_space<2>(-(3 * rise + a) * inward, inward, names[k]));
    drive(scene.walls.back(), 100);
  }
  return scene;
}

/// Equal disks on an inverted catenary: contact k carries (T, V_k) with V_k = (k - n/2) m g, the
/// direction of the line between its two centres. Two planes across the end links bear it.
Scene<2> arch(int disks) {
  Scene<2> scene = empty_scene(0.3);
  const double a = 0.5, weight = 9.81, thrust = 1.5 * weight;
  const auto link = [&](int k) { return Vec2(thrust, weight * (0.5 * disks - k)).normalized(); };
  Vec2 x = Vec2::Zero();
  for (int k = 0; k < disks; ++k) {
    scene.bodies.push_back(round_body<2>(x, a, 1));
    x += 2 * a * link(k + 1);
  }
  scene.walls.push_back(half_space<2>(-a * link(0), link(0), "left"));
  scene.walls.push_back(
      half_space<2>(scene.bodies.back().x + a * link(disks), -link(disks), "right"));
  return scene;
}

}  // namespace

void add_hyperstatic_cases(std::vector<ExtremeCase>& cases) {
  Scene<2> box = make_family_scene("square", 6);
  drive(box.walls[2], 1000);
  add_pressed(cases, "prestressed_lattice",
              "a square lattice of 36 disks in a box whose right wall presses with 1000 N", box);
  Scene<2> chain = empty_scene(0.3);
  chain.gravity.setZero();
  chain.bodies = touching_rows(8, 4);
  chain.walls = {half_space<2>(Vec2::Zero(), Vec2(1, 0), "left"),
                 half_space<2>(Vec2(8, 0), Vec2(-1, 0), "right")};
  drive(chain.walls[1], 1000);
  add_pressed(cases, "redundant_chains",
              "four touching rows of 8 disks between a wall and one that presses with 1000 N",
              chain);
  add_pressed(cases, "hexagon",
              "a hexagonal block of 37 disks pressed by six walls with 100 N each", hexagon());
  Scene<2> wedge = empty_scene(1);
  wedge.bodies = {round_body<2>(Vec2(0, 1), 0.5, 1)};
  add_wedge(wedge, std::numbers::pi / 6);
  add_at_rest(cases, "jammed_wedge",
              "a disk in a wedge of 60 degrees with mu = 1: it can be pressed in without a load",
              "two normal impulses and no friction hold the weight: rest obeys the law", wedge);
  add_at_rest(cases, "arch", "an arch of 11 equal disks on an inverted catenary between two planes",
              "impulses along the centres balance every weight: rest obeys the law", arch(11));
  Scene<2> row = empty_scene(0.3);
  row.bodies = touching_rows(10, 1);
  row.walls = {flat_floor<2>(), half_space<2>(Vec2::Zero(), Vec2(1, 0), "push")};
  drive(row.walls[1], 50);
  cases.push_back(
      {.name = "pushed_row",
       .what = "ten touching disks on a plane, the first pushed with 50 N",
       .known = "floor and wall bear no self-stress (the far end is free): a solution exists. "
                "All friction of the floor is at most mu 10 m g = 29.4 N",
       .problem = step_of(row)});
  const Scene<2> column = tower(std::vector<double>(1000, 1.0), {0.5});
  cases.push_back({.name = "column_1000",
                   .what = "a column of 1000 equal disks",
                   .known = "contact k carries k weights, without friction; W is regular",
                   .problem = step_of(column),
                   .true_error = against(tower_impulses(column)),
                   .large = true});
}

}  // namespace bipot
