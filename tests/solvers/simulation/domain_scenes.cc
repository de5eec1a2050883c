#include "tests/solvers/simulation/domain_scenes.h"

#include "core/scene/generators.h"
#include "core/scene/scene_family.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

Scene<2> boxed(double width, const ContactLaw& law) {
  Scene<2> scene = heavy_scene(law, 2e-3);
  scene.contact_distance = 1e-9;
  scene.walls = trough(width);
  return scene;
}

/// A disk that touches as many small ones as fit around it, with the largest number: contacts
/// belong to the small ones.
Scene<2> one_touches_all() {
  Scene<2> scene = boxed(20, {.mu = 0.3});
  constexpr int kAround = 24;
  for (int k = 0; k < kAround; ++k) {
    const double angle = (k + 0.3) * 6.283185307179586 / kAround;
    const Vec2 out(std::cos(angle), std::sin(angle));
    scene.bodies.push_back(round_body<2>(Vec2(10, 10) + 4.399 * out, 0.4, 2));
    scene.bodies.push_back(round_body<2>(Vec2(10, 10) + 5.1985 * out, 0.4, 2));
  }
  scene.bodies.push_back(round_body<2>(Vec2(10, 10), 4, 2));
  return scene;
}

Scene<2> two_disks() {
  Scene<2> scene = boxed(3, {.mu = 0.3});
  scene.bodies = {round_body<2>(Vec2(0.499, 0.499), 0.5, 2),
                  round_body<2>(Vec2(1.498, 0.499), 0.5, 2)};
  return scene;
}

/// Rows of a rectangular lattice; the lowest is glued to a floor that moves, the lid is driven.
Scene<2> sheared() {
  Scene<2> scene = pressed_box(6);
  move_at(scene.walls[0], Vec2(0.3, 0));
  for (Disk& d : scene.bodies) {
    if (d.x[1] < 0.6) d.wall = 0;
    if (d.x[1] > 5.2) d.wall = 3;
    if (d.wall >= 0) d.mass = d.inertia = 0;
  }
  return scene;
}

}  // namespace

Scene<2> breaking_dam(int disks) {
  Scene<2> scene = boxed(30, {.mu = 0.2, .e_n = 0.2});
  scene.bodies =
      random_filling(disks, {{0.3, 0.3}, {0.4, 0.4}, {0.5, 0.3}}, 8, 0.02, 3, Vec2(0, 0));
  for (Disk& d : scene.bodies) give_mass(d, 3.1 * d.radius * d.radius);
  scene.step = 1e-2;
  return scene;
}

Scene<2> pressed_box(int side) {
  const double width = side * 0.999;
  Scene<2> scene = boxed(width, {.mu = 0.3});
  for (Disk d : rectangular_lattice(side, side, 0.4995, Vec2(0, 0))) {
    scene.bodies.push_back(round_body<2>(d.x, 0.5, 2));
  }
  Wall<2> lid = half_space<2>(Vec2(0, width), Vec2(0, -1));
  drive(lid, Vec2(0, -1), 10, 200);
  scene.walls.push_back(lid);
  return scene;
}

Scene<3> box_of_spheres() {
  Scene<3> scene = heavy_scene<3>({.mu = 0.3, .e_n = 0.1}, 2e-3);
  scene.contact_distance = 1e-9;
  scene.walls = {
      half_space<3>(Vec3(0, 0, 0), Vec3(0, 0, 1)), half_space<3>(Vec3(0, 0, 0), Vec3(1, 0, 0)),
      half_space<3>(Vec3(4, 0, 0), Vec3(-1, 0, 0)), half_space<3>(Vec3(0, 0, 0), Vec3(0, 1, 0)),
      half_space<3>(Vec3(0, 4, 0), Vec3(0, -1, 0))};
  for (int k = 0; k < 64; ++k) {
    const Vec3 cell(k % 4, k / 4 % 4, k / 16);
    scene.bodies.push_back(round_body<3>(0.9985 * cell + Vec3(0.499 + 0.01 * cell[2], 0.499, 0.499),
                                         0.5, 2, Vec3(0.3, 0.1, 0)));
  }
  return scene;
}

std::vector<NamedScene> domain_scenes() {
  std::vector<NamedScene> list;
  list.push_back({"triangular", make_family_scene("triangular", 9)});
  list.push_back({"no friction", make_family_scene("triangular", 7, {.mu = 0})});
  list.push_back({"one touches all", one_touches_all()});
  list.push_back({"two disks", two_disks()});
  list.push_back({"pressed", pressed_box(6)});
  list.push_back({"sheared", sheared()});
  Scene<2> apart = two_disks();
  apart.bodies[0].x[1] = apart.bodies[1].x[1] = 9;
  apart.bodies[1].x[0] = 2;
  list.push_back({"no contact", apart});
  return list;
}

}  // namespace bipot
