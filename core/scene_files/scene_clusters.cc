#include <Eigen/Geometry>
#include <numbers>

#include "core/base/portable_random.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/disk_union.h"
#include "core/scene/generators.h"
#include "core/scene_files/scene_filling.h"
#include "core/scene_files/scene_groups.h"
#include "core/scene_files/scene_tables.h"

namespace bipot {
namespace {

/// The disks of a cluster as the file has them, and about the centre of their union.
std::vector<Circle> read_parts(const SceneTable& table) {
  if (!table.has("parts")) table.fail("parts", "is missing");
  std::vector<Circle> parts;
  for (const std::vector<double>& row : table.rows("parts", 3)) {
    if (!(row[2] > 0)) table.fail("parts", "expected rows [x, y, radius] with a positive radius");
    parts.push_back({Vec2(row[0], row[1]), row[2]});
  }
  if (parts.empty()) table.fail("parts", "is empty");
  return parts;
}

/// Centres of mass of a group's clusters, and the rotation of each.
struct Placed {
  Vec2 x;
  double angle;
};

/// `reach`: radius about the centre of the union that contains a cluster.
std::vector<Placed> read_places(const SceneTable& table, const Scene<2>& scene, double reach,
                                const Vec2& centre) {
  const double turned = table.number("degrees", 0) * std::numbers::pi / 180;
  const std::string arrangement =
      table.one_of("arrangement", "single", {"single", "rectangular", "random"});
  if (arrangement == "single") {
    const auto position = table.maybe_vec2("position");
    if (!position) table.fail("position", "is missing");
    // The place of the origin of the parts.
    return {{*position + Eigen::Rotation2D<double>(turned) * centre, turned}};
  }
  std::vector<Placed> places;
  if (arrangement == "rectangular") {
    const Vec2 corner = table.vec2("corner", Vec2::Zero());
    const int columns = table.natural("columns"), rows = table.natural("rows");
    require_possible(table, "rows", static_cast<double>(rows) * columns, "clusters");
    for (const Disk& cell : rectangular_lattice(columns, rows, reach, corner)) {
      places.push_back({cell.x, turned});
    }
    return places;
  }
  if (table.has("degrees")) table.fail("degrees", "the clusters of a random group turn at random");
  const int seed = table.integer("seed", 1);
  if (seed < 0) table.fail("seed", "expected a non-negative integer");
  const int count = table.natural("count");
  require_possible(table, "count", count, "clusters");
  PortableRandom random(static_cast<std::uint64_t>(seed));
  const FillingPlace<2> place = read_filling_place(table, scene);
  try {
    for (const Disk& cell :
         random_filling(count, {{reach, 1}}, place.base[0], table.number("spacing", 0.1),
                        static_cast<std::uint64_t>(seed), place.corner, place.bounds)) {
      places.push_back({cell.x, 2 * std::numbers::pi * random.uniform()});
    }
  } catch (const std::invalid_argument& e) {
    table.fail("arrangement", e.what());
  }
  return places;
}

void read_cluster_group(const SceneTable& table, Scene<2>& scene) {
  const std::vector<Circle> parts = read_parts(table);
  const Vec2 centre = union_moments(parts).centre;
  double reach = 0;
  for (const Circle& part : parts) {
    reach = std::max(reach, (part.centre - centre).norm() + part.radius);
  }
  const std::vector<Placed> places = read_places(table, scene, reach, centre);
  const GroupMass group = read_group_mass(table);
  if (group.inertia && !(*group.inertia > 0)) {
    table.fail("inertia", "expected a positive number");
  }
  const Vec2 v = table.vec2("velocity", Vec2::Zero());
  const double spin = table.number("spin", 0);
  const int material = material_index(scene, table, "material");
  for (const Placed& place : places) {
    const Eigen::Rotation2D<double> turn(place.angle);
    for (const Circle& part : parts) {
      Disk disk;
      disk.x = place.x + turn * (part.centre - centre);
      disk.radius = part.radius;
      disk.material = material;
      disk.v = v;
      disk.spin = spin;
      scene.bodies.push_back(disk);
    }
    const std::size_t before = scene.clusters.bodies.size();
    try {
      join_disks(scene, parts.size(),
                 {.mass = group.mass.value_or(0),
                  .density = group.density.value_or(0),
                  .inertia = group.inertia.value_or(0)});
    } catch (const std::invalid_argument& e) {
      table.fail("parts", e.what());
    }
    if (scene.clusters.bodies.size() == before) continue;  // one disk stays a disk
    scene.clusters.bodies.back().v = v;
    scene.clusters.bodies.back().spin = spin;
  }
}

}  // namespace

void read_clusters(const SceneTable& root, Scene<2>& scene) {
  for (const SceneTable& table : root.tables("clusters")) {
    read_cluster_group(table, scene);
    table.finish();
  }
  place_members(scene.clusters, scene.bodies);
}

}  // namespace bipot
