#include "bench/compare/random_scene.h"

#include "core/base/portable_random.h"
#include "core/scene/scene_parts.h"

namespace bipot {
Scene<2> random_scene(std::uint64_t seed, int index) {
  PortableRandom draw(seed ^ 0x5ce4e5ull, static_cast<std::uint64_t>(index));
  const double kilogram = draw.decades(-6, 6), metre = draw.decades(-6, 6),
               second = draw.decades(-6, 6);
  Scene<2> scene;
  scene.title = "random scene";
  scene.source = "generated";
  scene.gravity = metre / (second * second) * Vec2(draw.between(-3, 3), -10);
  scene.materials = {"m"};
  const double mus[] = {0, 1e-12, draw.uniform(), draw.between(1, 10), 1e6};
  ContactLaw law{.mu = mus[draw.below(5)]};
  law.e_n = draw.chance(0.5) ? 0 : draw.uniform();
  law.e_t = draw.chance(1.0 / 3) ? draw.uniform() : law.e_n;
  scene.laws = {law};
  scene.step = 0.01 * second;
  scene.num_steps = 1000;
  scene.contact_distance = 1e-9 * metre;
  // Columns of a grid one metre wide, each disk in its cell; big ones touch their neighbours.
  const int columns = 1 + draw.below(5), rows = 1 + draw.below(4);
  const double spread = draw.chance(0.5) ? 0 : draw.between(0, 6);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      Disk d;
      d.radius = metre * (draw.chance(0.4) ? 0.5 : draw.decades(-3, std::log10(0.5)));
      d.x = metre * Vec2(column + 0.5, row) + Vec2(0, d.radius);
      d.v = metre / second * draw.decades(-3, 1.5) * Vec2(draw.between(-1, 1), -draw.uniform());
      d.spin = draw.between(-1, 1) / second;
      d.mass = kilogram * draw.decades(0, spread);
      d.inertia = 0.5 * d.mass * d.radius * d.radius * (draw.chance(0.2) ? draw.decades(-2, 2) : 1);
      scene.bodies.push_back(d);
    }
  }
  scene.walls.push_back(flat_floor<2>());
  if (draw.chance(0.6)) {
    scene.walls.push_back(half_space<2>(Vec2::Zero(), Vec2(1, 0), "left"));
    scene.walls.push_back(half_space<2>(Vec2(metre * columns, 0), Vec2(-1, 0), "right"));
  }
  if (draw.chance(0.2)) {
    Wall<2>& wall = scene.walls.back();
    if (draw.chance(0.5)) {
      move_at(wall, metre / second * 0.1 * wall.normal);
    } else {
      drive(wall, wall.normal, kilogram, 10 * kilogram * metre / (second * second));
    }
  }
  return scene;
}

bool contacts_must_dissipate(const Scene<2>& scene) {
  for (const Wall<2>& wall : scene.walls) {
    if (wall.motion != Wall<2>::Motion::kFixed) return false;
  }
  for (const ContactLaw& law : scene.laws) {
    if (law.e_n != scene.laws[0].e_n || (law.mu > 0 && law.e_t != scene.laws[0].e_n)) return false;
  }
  return true;
}

}  // namespace bipot
