#include <fmt/format.h>

#include "bench/compare/case_parts.h"
#include "bench/compare/extreme_case.h"
#include "core/scene/scene_family.h"

namespace bipot {
namespace {

/// A disk flies into the corner of a floor and a wall.
Scene<2> corner(double e_n, double e_t, const Vec2& v) {
  Scene<2> scene = empty_scene(0.9, e_n, e_t);
  scene.gravity.setZero();
  scene.step = 1e-3;
  scene.bodies = {round_body<2>(Vec2(0.5, 0.5), 0.5, 1)};
  scene.bodies[0].v = v;
  scene.walls = {flat_floor<2>(), half_space<2>(Vec2::Zero(), Vec2(1, 0), "wall")};
  return scene;
}

}  // namespace

void add_restitution_cases(std::vector<ExtremeCase>& cases) {
  for (const double e_n : {0.0, 0.5, 1.0}) {
    for (const double e_t : {0.0, 0.5, 1.0}) {
      const bool one = e_n == e_t;
      cases.push_back(
          {.name = fmt::format("corner_e_{:g}_{:g}", e_n, e_t),
           .what = fmt::format(
               "a disk flies at (-1, -1.5) m/s into a corner, mu = 0.9, e_n = {:g}, e_t = {:g}",
               e_n, e_t),
           .known =
               one ? "one coefficient for all rows: the contacts create no energy"
                   : "mu < 1: no self-stress in the corner, so that a solution exists; the normal of "
                     "one contact is the tangent of the other, e_n and e_t differ: Newton's law may "
                     "create energy",
           .scene = [=] { return corner(e_n, e_t, Vec2(-1, -1.5)); },
           .steps = 1,
           .must_dissipate = one});
    }
  }
  cases.push_back(
      {.name = "elastic_gas",
       .what = "16 frictionless disks in a box, e_n = 1, thrown at each other for 200 steps",
       .known = "s·u = 0 and e = 1: the impulses do no work, kinetic energy is kept",
       .scene =
           [] {
             Scene<2> scene = make_family_scene("random", 4, {.mu = 0, .e_n = 1});
             scene.gravity.setZero();
             for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
               const double k = static_cast<double>(i);
               scene.bodies[i].v = Vec2(7 - k, 3 * static_cast<double>(i % 3) - 3);
             }
             return scene;
           },
       .steps = 200,
       .must_dissipate = true,
       .must_conserve = true});
  cases.push_back(
      {.name = "pile_hit_e_0.5",
       .what =
           "a triangular lattice of 33 disks falls at 5 m/s on a floor, e_n = e_t = 0.5, 10 steps",
       .known = "one coefficient and walls that stand: the contacts create no energy",
       .scene =
           [] {
             Scene<2> scene = make_family_scene("triangular", 6, {.e_n = 0.5, .e_t = 0.5});
             for (Disk& d : scene.bodies) d.v = Vec2(0, -5);
             return scene;
           },
       .steps = 10,
       .must_dissipate = true});
}

}  // namespace bipot
