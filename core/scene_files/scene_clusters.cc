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

/// The bodies of a cluster as the file has them.
template <int D>
std::vector<Body<D>> read_parts(const SceneTable& table, int material) {
  if (!table.has("parts")) table.fail("parts", "is missing");
  std::vector<Body<D>> parts;
  for (const std::vector<double>& row : table.rows("parts", D + 1)) {
    if (!(row[D] > 0)) {
      table.fail("parts", D == 2 ? "expected rows [x, y, radius] with a positive radius"
                                 : "expected rows [x, y, z, radius] with a positive radius");
    }
    parts.push_back({.x = Vec<D>(row.data()), .radius = row[D], .material = material});
  }
  if (parts.empty()) table.fail("parts", "is empty");
  return parts;
}

/// Radius about the centre that contains them all.
template <int D>
double reach_of(const std::vector<Body<D>>& parts, const Vec<D>& centre) {
  double reach = 0;
  for (const Body<D>& part : parts) {
    reach = std::max(reach, (part.x - centre).norm() + part.radius);
  }
  return reach;
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
    const Vec2 position = table.vec<2>("position");
    // The place of the origin of the parts.
    return {{position + Eigen::Rotation2D<double>(turned) * centre, turned}};
  }
  std::vector<Placed> places;
  if (arrangement == "rectangular") {
    const Vec2 corner = table.vec_or_zero<2>("corner");
    const int columns = table.natural("columns"), rows = table.natural("rows");
    require_possible(table, "rows", static_cast<double>(rows) * columns, "clusters");
    for (const Disk& cell : rectangular_lattice(columns, rows, reach, corner)) {
      places.push_back({cell.x, turned});
    }
    return places;
  }
  if (table.has("degrees")) table.fail("degrees", "the clusters of a random group turn at random");
  PortableRandom random(read_seed(table));
  for (const Disk& cell : read_filling(table, scene, "clusters", reach)) {
    places.push_back({cell.x, 2 * std::numbers::pi * random.uniform()});
  }
  return places;
}

void read_cluster_group(const SceneTable& table, Scene<2>& scene) {
  const std::vector<Disk> parts = read_parts<2>(table, 0);
  std::vector<Circle> circles;
  for (const Disk& part : parts) circles.push_back({part.x, part.radius});
  const Vec2 centre = union_moments(circles).centre;
  const std::vector<Placed> places = read_places(table, scene, reach_of<2>(parts, centre), centre);
  const GroupMass group = read_group_mass(table);
  const Vec2 v = table.vec_or_zero<2>("velocity");
  const double spin = table.spin<2>();
  const int material = material_index(scene, table, "material");
  for (const Placed& place : places) {
    const Eigen::Rotation2D<double> turn(place.angle);
    for (const Disk& part : parts) {
      scene.bodies.push_back({.x = place.x + turn * (part.x - centre),
                              .v = v,
                              .spin = spin,
                              .radius = part.radius,
                              .material = material});
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

/// Uniform among all rotations (Shoemake, Graphics Gems III, 1992).
Eigen::Quaterniond random_turn(PortableRandom& random) {
  const double u = random.uniform(), a = 2 * std::numbers::pi * random.uniform(),
               b = 2 * std::numbers::pi * random.uniform();
  return {std::sqrt(u) * std::cos(b), std::sqrt(1 - u) * std::sin(a),
          std::sqrt(1 - u) * std::cos(a), std::sqrt(u) * std::sin(b)};
}

/// Calls add(x, turn) for the centre of mass and the rotation of each cluster.
template <class Add>
void place_in_space(const SceneTable& table, const Scene<3>& scene, double reach,
                    const Vec3& centre, const Add& add) {
  const Vec3 axis = table.has("axis") ? table.direction<3>("axis") : Vec3::UnitZ();
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(table.number("degrees", 0) * std::numbers::pi / 180, axis));
  const std::string arrangement =
      table.one_of("arrangement", "single", {"single", "cubic", "random"});
  if (arrangement == "single") {
    add(table.vec<3>("position") + turn * centre, turn);
    return;
  }
  if (arrangement == "cubic") {
    const Vec3 corner = table.vec_or_zero<3>("corner");
    const int columns = table.natural("columns"), rows = table.natural("rows"),
              layers = table.natural("layers");
    require_possible(table, "layers", static_cast<double>(columns) * rows * layers, "clusters");
    for (const Sphere& cell : cubic_lattice(columns, rows, layers, reach, corner)) {
      add(cell.x, turn);
    }
    return;
  }
  for (const char* key : {"degrees", "axis"}) {
    if (table.has(key)) table.fail(key, "the clusters of a random group turn at random");
  }
  PortableRandom random(read_seed(table));
  for (const Sphere& cell : read_filling(table, scene, "clusters", reach)) {
    add(cell.x, random_turn(random));
  }
}

void read_cluster_group(const SceneTable& table, Scene<3>& scene) {
  const std::vector<Sphere> parts = read_parts<3>(table, material_index(scene, table, "material"));
  const GroupMass group = read_group_mass(table, parts.size() == 1);
  Clusters<3>::Mass given{group.mass.value_or(0), group.density.value_or(0), Vec3::Zero()};
  if (parts.size() > 1) {
    given.inertia = table.vec_or_zero<3>("inertia");
    if (table.has("inertia") && !(given.inertia.minCoeff() > 0)) {
      table.fail("inertia", "expected three positive numbers");
    }
  }
  Cluster<3> body;
  try {
    body = joined(parts, given);
  } catch (const std::invalid_argument& e) {
    table.fail("parts", e.what());
  }
  body.v = table.vec_or_zero<3>("velocity");
  body.spin = table.spin<3>();
  const double reach = reach_of<3>(parts, body.x);
  place_in_space(table, scene, reach, body.x, [&](const Vec3& x, const Eigen::Quaterniond& turn) {
    if (parts.size() > 1) {
      add_cluster(scene, body, parts, x, turn);
      return;
    }
    Sphere sphere = parts[0];  // stays a sphere
    sphere.x = x;
    sphere.v = body.v;
    sphere.spin = body.spin;
    sphere.mass = body.mass;
    sphere.inertia = group.inertia.value_or(body.inertia[0]);
    scene.bodies.push_back(sphere);
  });
  if (!scene.clusters.empty()) scene.clusters.arms.resize(scene.bodies.size(), Vec3::Zero());
}

}  // namespace

template <int D>
void read_clusters(const SceneTable& root, Scene<D>& scene) {
  for (const SceneTable& table : root.tables("clusters")) {
    read_cluster_group(table, scene);
  }
  place_members(scene.clusters, scene.bodies);
}

template void read_clusters(const SceneTable&, Scene<2>&);
template void read_clusters(const SceneTable&, Scene<3>&);

}  // namespace bipot
