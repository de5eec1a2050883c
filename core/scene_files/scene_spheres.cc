#include <fmt/format.h>

#include "core/scene/scene_parts.h"
#include "core/scene/sphere_generators.h"
#include "core/scene_files/scene_filling.h"
#include "core/scene_files/scene_groups.h"
#include "core/scene_files/scene_tables.h"

namespace bipot {
namespace {

/// A wall that carries a driven sphere, which is glued to it, and is hidden in it.
Wall<3> carrier(const PositionRow& row, std::size_t number) {
  Wall<3> wall{.name = fmt::format("driven {}", number),
               .shape = Wall<3>::Shape::kCone,
               .a = row.x - 0.25 * row.radius * Vec3::UnitZ(),
               .b = row.x + 0.25 * row.radius * Vec3::UnitZ(),
               .v = row.v,
               .radius = 0.1 * row.radius,
               .radius_b = 0.1 * row.radius};
  if (!row.v.isZero(0)) wall.motion = Wall<3>::Motion::kMoving;
  return wall;
}

std::vector<Sphere> read_arrangement(const SceneTable& table, Scene<3>& scene) {
  static const std::vector<std::string> kArrangements = {"single", "cubic", "pyramid", "random",
                                                         "file"};
  const std::string arrangement = table.one_of("arrangement", "single", kArrangements);
  if (arrangement == "single") {
    return {{.x = table.vec<3>("position"), .radius = table.positive("radius")}};
  }
  if (arrangement == "file") {
    std::vector<Sphere> spheres;
    for (const PositionRow& row : read_named_positions(table, 3, scene.caution)) {
      spheres.push_back({.x = row.x, .v = row.v, .spin = row.spin, .radius = row.radius});
      if (!row.driven) continue;
      spheres.back().wall = static_cast<int>(scene.walls.size());
      scene.walls.push_back(carrier(row, scene.walls.size()));
    }
    return spheres;
  }
  if (arrangement == "random") return read_filling(table, scene, "spheres");
  const Vec3 corner = table.vec_or_zero<3>("corner");
  const double radius = table.positive("radius");
  const int rows = table.natural("rows");
  if (arrangement == "pyramid") {
    require_possible(table, "rows", rows * (rows + 1.0) * (2.0 * rows + 1) / 6, "spheres");
    return sphere_pyramid(rows, radius, corner);
  }
  const int columns = table.natural("columns"), layers = table.natural("layers");
  require_possible(table, "layers", static_cast<double>(columns) * rows * layers, "spheres");
  return cubic_lattice(columns, rows, layers, radius, corner);
}

}  // namespace

std::vector<Sphere> read_spheres(const SceneTable& table, Scene<3>& scene) {
  std::vector<Sphere> spheres = read_arrangement(table, scene);
  const GroupMass group = read_group_mass(table);
  const Vec3 v = table.vec_or_zero<3>("velocity");
  const Vec3 spin = table.spin<3>();
  const int material = material_index(scene, table, "material");
  for (Sphere& s : spheres) {
    s.material = material;
    if (s.wall >= 0) continue;
    s.mass = group.mass ? *group.mass : *group.density * extent(s);
    s.inertia = group.inertia.value_or(0.4 * s.mass * s.radius * s.radius);
    s.v += v;  // to that of a file
    s.spin += spin;
  }
  return spheres;
}

}  // namespace bipot
