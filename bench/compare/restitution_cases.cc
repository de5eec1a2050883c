#include <fmt/format.h>

#include "bench/compare/case_parts.h"
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

constexpr const char* kLawNames[] = {"newton", "poisson", "fremond"};  // as ContactLaw::Impact

/// Five equal disks that touch in the middle of the step, in which the first one strikes the others.
Scene<2> struck_disks(ContactLaw::Impact impact) {
  Scene<2> scene = empty_scene(0, 1, 0);
  scene.impact = impact;
  scene.gravity.setZero();
  scene.step = 1e-3;
  for (int k = 0; k < 5; ++k) scene.bodies.push_back(round_body<2>(Vec2(k, 0), 0.5, 1));
  scene.bodies[0].v = Vec2(1, 0);
  scene.bodies[0].x[0] = -0.5 * scene.step;
  return scene;
}

/// A lattice of disks of two materials flies into the corner of its box.
Scene<2> mixed_disks(ContactLaw::Impact impact, double mu) {
  Scene<2> scene = make_family_scene("triangular", 4, {});
  scene.impact = impact;
  scene.gravity.setZero();
  scene.materials = {"elastic", "dull"};
  scene.laws = {{.mu = mu, .e_n = 1}, {.mu = mu}, {.mu = mu}, {.mu = mu, .e_n = 0.5}};
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    scene.bodies[k].material = static_cast<int>(k % 2);
    scene.bodies[k].v = Vec2(-2, -3);
  }
  return scene;
}

void add_impact_laws(std::vector<ExtremeCase>& cases) {
  for (const auto impact :
       {ContactLaw::Impact::kNewton, ContactLaw::Impact::kPoisson, ContactLaw::Impact::kFremond}) {
    const std::string law = kLawNames[static_cast<int>(impact)];
    cases.push_back({.name = "row_" + law,
                     .what = "a row of five equal disks that touch is struck at its end, e_n = 1, "
                             "impact = \"" +
                             law + '"',
                     .known = "one coefficient, no friction: the three laws agree and keep the "
                              "energy; the disks leave with -0.6 and four times 0.4",
                     .scene = [=] { return struck_disks(impact); },
                     .steps = 2,
                     .must_dissipate = true,
                     .must_conserve = true});
  }
  for (const auto impact :
       {ContactLaw::Impact::kNewton, ContactLaw::Impact::kPoisson, ContactLaw::Impact::kFremond}) {
    const bool newton = impact == ContactLaw::Impact::kNewton;
    const double mu = impact == ContactLaw::Impact::kPoisson ? 0 : 0.5;
    const std::string law = kLawNames[static_cast<int>(impact)];
    cases.push_back(
        {.name = "mixed_e_" + law,
         .what = fmt::format("14 disks of two materials, e_n = 1, 0 and 0.5, mu = {:g}, fly into a "
                             "corner, 10 steps, impact = \"{}\"",
                             mu, law),
         .known = newton   ? "the coefficients differ: Newton's law may create energy"
                  : mu > 0 ? "friction and restitution act on mean velocities: the contacts create "
                             "no energy"
                           : "no friction: Poisson's law creates no energy, whatever e_n",
         .scene = [=] { return mixed_disks(impact, mu); },
         .steps = 10,
         .must_dissipate = !newton});
  }
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
  add_impact_laws(cases);
}

}  // namespace bipot
