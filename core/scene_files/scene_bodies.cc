#include <fmt/format.h>

#include <numbers>

#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"
#include "core/scene_files/scene_filling.h"
#include "core/scene_files/scene_groups.h"
#include "core/scene_files/scene_tables.h"

namespace bipot {
namespace {

/// A driven disk is a solid circle among the walls, and none of the bodies.
bool add_driven(const PositionRow& row, int material, Scene<2>& scene, Disk& /*disk*/) {
  Wall<2> wall{.name = fmt::format("driven {}", scene.walls.size()),
               .shape = Wall<2>::Shape::kSolidCircle,
               .a = row.x.head<2>(),
               .v = row.v.head<2>(),
               .material = material,
               .radius = row.radius,
               .spin = row.spin[2]};
  if (!row.v.isZero(0) || wall.spin != 0) wall.motion = Wall<2>::Motion::kMoving;
  scene.walls.push_back(wall);
  return false;
}

/// A driven sphere is glued to a wall that carries it, and is hidden in it.
bool add_driven(const PositionRow& row, int /*material*/, Scene<3>& scene, Sphere& sphere) {
  Wall<3> wall{.name = fmt::format("driven {}", scene.walls.size()),
               .shape = Wall<3>::Shape::kCone,
               .a = row.x - 0.25 * row.radius * Vec3::UnitZ(),
               .b = row.x + 0.25 * row.radius * Vec3::UnitZ(),
               .v = row.v,
               .radius = 0.1 * row.radius,
               .radius_b = 0.1 * row.radius};
  if (!row.v.isZero(0)) wall.motion = Wall<3>::Motion::kMoving;
  sphere.wall = static_cast<int>(scene.walls.size());
  scene.walls.push_back(wall);
  return true;
}

void set_spin(const Vec3& spin, Disk& disk) { disk.spin = spin[2]; }
void set_spin(const Vec3& spin, Sphere& sphere) { sphere.spin = spin; }

template <int D>
std::vector<Body<D>> read_file(const SceneTable& table, int material, Scene<D>& scene) {
  std::vector<Body<D>> bodies;
  for (const PositionRow& row : read_named_positions(table, D, scene.caution)) {
    Body<D> body{.x = row.x.head<D>(), .v = row.v.head<D>(), .radius = row.radius};
    set_spin(row.spin, body);
    if (!row.driven || add_driven(row, material, scene, body)) bodies.push_back(body);
  }
  return bodies;
}

std::vector<Disk> read_lattice(const SceneTable& table, const std::string& arrangement, int rows,
                               double radius, const Vec2& corner) {
  if (arrangement == "pyramid") {
    require_possible(table, "rows", 0.5 * rows * (rows + 1.0), "disks");
    return pyramid(rows, radius, corner);
  }
  const int columns = table.natural("columns");
  require_possible(table, "rows", static_cast<double>(rows) * columns, "disks");
  return arrangement == "rectangular" ? rectangular_lattice(columns, rows, radius, corner)
                                      : triangular_lattice(columns, rows, radius, corner);
}
std::vector<Sphere> read_lattice(const SceneTable& table, const std::string& arrangement, int rows,
                                 double radius, const Vec3& corner) {
  if (arrangement == "pyramid") {
    require_possible(table, "rows", rows * (rows + 1.0) * (2.0 * rows + 1) / 6, "spheres");
    return sphere_pyramid(rows, radius, corner);
  }
  const int columns = table.natural("columns"), layers = table.natural("layers");
  require_possible(table, "layers", static_cast<double>(columns) * rows * layers, "spheres");
  return cubic_lattice(columns, rows, layers, radius, corner);
}

template <int D>
std::vector<Body<D>> read_arrangement(const SceneTable& table, int material, Scene<D>& scene) {
  static const std::vector<std::string> kArrangements =
      D == 2 ? std::vector<std::string>{"single",  "rectangular", "triangular",
                                        "pyramid", "random",      "file"}
             : std::vector<std::string>{"single", "cubic", "pyramid", "random", "file"};
  const std::string arrangement = table.one_of("arrangement", "single", kArrangements);
  if (arrangement == "single") {
    return {{.x = table.vec<D>("position"), .radius = table.positive("radius")}};
  }
  if (arrangement == "file") return read_file(table, material, scene);
  if (arrangement == "random") return read_filling(table, scene, D == 2 ? "disks" : "spheres");
  const Vec<D> corner = table.vec_or_zero<D>("corner");
  const double radius = table.positive("radius");
  return read_lattice(table, arrangement, table.natural("rows"), radius, corner);
}

/// Disks that are glued to a wall, as its key says.
void glue(const SceneTable& table, const Scene<2>& scene, std::vector<Disk>& disks) {
  for (const char* key : {"mass", "density", "inertia", "velocity", "spin"}) {
    if (table.has(key)) table.fail(key, "belongs to disks that are not glued to a wall");
  }
  const std::size_t wall =
      table.index_of("wall", "wall", table.word("wall", ""), names_of(scene.walls));
  for (Disk& d : disks) {
    if (!d.v.isZero(0) || d.spin != 0) {
      table.fail("file", "has velocities or spins, but glued disks move with their wall");
    }
    d.wall = static_cast<int>(wall);
    d.v = scene.walls[wall].v;
  }
}

double homogeneous_mass(const Disk& d, double density) {
  return density * std::numbers::pi * d.radius * d.radius;
}
double homogeneous_mass(const Sphere& s, double density) { return density * extent(s); }

/// One table of [[disks]] or [[spheres]]: a body or an arrangement.
template <int D>
std::vector<Body<D>> read_group(const SceneTable& table, Scene<D>& scene) {
  const int material = material_index(scene, table, "material");
  std::vector<Body<D>> bodies = read_arrangement(table, material, scene);
  for (Body<D>& body : bodies) body.material = material;
  if constexpr (D == 2) {
    if (table.has("wall")) {
      glue(table, scene, bodies);
      return bodies;
    }
  }
  const GroupMass group = read_group_mass(table);
  const Vec<D> v = table.vec_or_zero<D>("velocity");
  const Spin<D> spin = table.spin<D>();
  for (Body<D>& body : bodies) {
    if (body.wall >= 0) continue;
    body.mass = group.mass ? *group.mass : homogeneous_mass(body, *group.density);
    body.inertia =
        group.inertia.value_or((D == 2 ? 0.5 : 0.4) * body.mass * body.radius * body.radius);
    body.v += v;  // to that of a file
    body.spin += spin;
  }
  return bodies;
}

}  // namespace

template <int D>
void read_bodies(const SceneTable& root, Scene<D>& scene) {
  for (const SceneTable& table : D == 2 ? root.tables("disks") : root.tables("spheres")) {
    const std::vector<Body<D>> bodies = read_group(table, scene);
    scene.bodies.insert(scene.bodies.end(), bodies.begin(), bodies.end());
  }
  read_clusters(root, scene);
}

template void read_bodies(const SceneTable&, Scene<2>&);
template void read_bodies(const SceneTable&, Scene<3>&);

}  // namespace bipot
