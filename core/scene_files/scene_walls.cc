#include "core/scene/triangle_mesh.h"
#include "core/scene_files/scene_tables.h"
#include "core/scene_files/stl_file.h"

namespace bipot {
namespace {

/// Half-plane or half-space.
template <int D>
void read_plane(const SceneTable& table, Wall<D>& wall) {
  wall.a = table.vec<D>("point");
  wall.normal = table.direction<D>("normal");
}

/// Circle or cylinder.
template <int D>
void read_circle(const SceneTable& table, Wall<D>& wall) {
  const bool hollow = table.boolean("hollow", false);
  wall.shape = hollow ? Wall<D>::Shape::kHollowCircle : Wall<D>::Shape::kSolidCircle;
  wall.a = table.vec<D>("center");
  if constexpr (D == 3) {
    if (!table.has("axis")) table.fail("axis", "is missing for a cylinder");
    wall.normal = table.direction<D>("axis");
  }
  wall.radius = table.positive("radius");
  wall.spin = table.number("spin", 0);
}

/// Half-plane, segment or circle.
void read_shape(const SceneTable& table, Wall<2>& wall) {
  const bool point = table.has("point"), normal = table.has("normal");
  const bool from = table.has("from"), to = table.has("to"), center = table.has("center");
  if (point && normal && !from && !to && !center) {
    read_plane(table, wall);
  } else if (from && to && !point && !normal && !center) {
    wall.shape = Wall<2>::Shape::kSegment;
    wall.a = table.vec<2>("from");
    wall.b = table.vec<2>("to");
  } else if (center && !point && !normal && !from && !to) {
    read_circle(table, wall);
  } else {
    table.fail(
        "point",
        "give point and normal (a half-plane), from and to (a segment), or center and radius "
        "(a circle)");
  }
}

/// A flat convex polygon as triangles about its first corner.
void read_polygon(const SceneTable& table, Wall<3>& wall) {
  std::vector<Vec3> corners;
  for (const auto& row : table.rows("corners", 3)) corners.emplace_back(row.data());
  if (corners.size() < 3) table.fail("corners", "expected three or more");
  wall.shape = Wall<3>::Shape::kMesh;
  wall.a = corners[0];
  for (Vec3& corner : corners) corner -= wall.a;
  std::vector<Wall<3>::Mesh::Triangle> triangles;
  const Vec3 first = corners[1].cross(corners[2]);
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
    triangles.push_back({corners[0], corners[k], corners[k + 1]});
  }
  double size = 0;
  for (const Vec3& corner : corners) size = std::max(size, corner.norm());
  if (!(first.norm() > 1e-12 * size * size)) table.fail("corners", "the first three lie on a line");
  wall.normal = first.normalized();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec3 side = corners[(k + 1) % corners.size()] - corners[k];
    const auto to_the_left = [&](std::size_t corner) {
      return wall.normal.dot(side.cross(corners[corner % corners.size()] - corners[k]));
    };
    if (std::abs(wall.normal.dot(corners[k])) > 1e-9 * size) {
      table.fail("corners", "do not lie in one plane");
    }
    bool convex = to_the_left(k + 2) > 0;
    for (std::size_t other = 0; other < corners.size(); ++other) {  // else it winds twice
      const bool again = other < k && corners[other] == corners[k];
      convex = convex && !again && to_the_left(other) >= -1e-9 * size * size;
    }
    if (!convex) table.fail("corners", "do not run round a convex polygon");
  }
  wall.mesh = std::make_shared<const Wall<3>::Mesh>(std::move(triangles));
}

/// The triangles of an STL file, scaled and then moved.
void read_mesh_file(const SceneTable& table, Wall<3>& wall) {
  auto triangles = read_stl(table.folder() / table.word("file", ""));
  const double scale = table.has("scale") ? table.positive("scale") : 1.0;
  for (auto& triangle : triangles) {
    for (Vec3& corner : triangle) corner *= scale;
  }
  wall.shape = Wall<3>::Shape::kMesh;
  wall.a = table.vec_or_zero<3>("point");
  wall.mesh = std::make_shared<const Wall<3>::Mesh>(std::move(triangles));
}

void read_cone(const SceneTable& table, Wall<3>& wall) {
  const std::vector<double> radii = table.numbers("radii");
  wall.shape = Wall<3>::Shape::kCone;
  for (const char* end : {"from", "to"}) {
    if (!table.has(end)) table.fail(end, "is missing for a cone");
  }
  wall.a = *table.maybe_vec<3>("from");
  wall.b = *table.maybe_vec<3>("to");
  if (radii.size() != 2 || !(std::min(radii[0], radii[1]) >= 0) || !(radii[0] + radii[1] > 0)) {
    table.fail("radii", "a cone needs two, at its ends, >= 0 and not both 0");
  }
  if (wall.a == wall.b) table.fail("to", "is the same point as from");
  wall.radius = radii[0];
  wall.radius_b = radii[1];
}

/// Half-space, cylinder, cone, polygon or triangles of a file.
void read_shape(const SceneTable& table, Wall<3>& wall) {
  const bool point = table.has("point"), normal = table.has("normal"), center = table.has("center");
  const bool cone = table.has("radii"), file = table.has("file");
  const int surfaces = table.has("corners") + file + cone;
  if (surfaces == 1 && (file || !point) && !normal && !center) {
    if (cone) return read_cone(table, wall);
    return file ? read_mesh_file(table, wall) : read_polygon(table, wall);
  }
  if (surfaces > 0) {
    table.fail(file   ? "file"
               : cone ? "radii"
                      : "corners",
               "give one shape: there are keys of several");
  }
  if (point && normal && !center) {
    read_plane(table, wall);
  } else if (center && !point && !normal) {
    read_circle(table, wall);
  } else {
    table.fail(
        "point",
        "give point and normal (a half-space), center, axis and radius (a cylinder), from, to "
        "and radii (a cone), corners (a polygon), or file (triangles)");
  }
}

/// Driven by a force. A velocity moves it across that direction.
template <int D>
void read_drive(const SceneTable& table, Wall<D>& wall) {
  const auto force = table.maybe_number("force"), mass = table.maybe_number("mass");
  if (!force || !mass) table.fail("force", "a driven wall needs force [N] and mass [kg]");
  wall.motion = Wall<D>::Motion::kDriven;
  wall.force = *force;
  wall.mass = *mass;
  if (!table.has("direction") && wall.shape != Wall<D>::Shape::kHalfPlane) {
    table.fail("direction", D == 2 ? "is missing for a driven segment or circle"
                                   : "is missing for this driven wall");
  }
  wall.direction =
      table.has("direction") ? table.direction<D>("direction") : wall.normal.normalized();
  wall.v = table.number("speed", 0) * wall.direction;
  if (const auto velocity = table.maybe_vec<D>("velocity")) {
    const double along = velocity->dot(wall.direction);
    if (!(std::abs(along) <= 1e-9 * velocity->norm())) {
      table.fail("velocity",
                 "a wall that a force drives can be moved across its direction only, not along it "
                 "(its initial speed along it is 'speed')");
    }
    wall.across = *velocity - along * wall.direction;
    wall.v += wall.across;
  }
}

/// A surface that moves along its wall, which stays.
template <int D>
void read_belt(const SceneTable& table, Wall<D>& wall) {
  if (wall.is_circle()) return;  // it has 'spin'
  const auto surface = table.maybe_vec<D>("surface_velocity");
  if (!surface) return;
  Vec<D> through = Vec<D>::Zero();  // the part along the normal
  if (wall.shape == Wall<D>::Shape::kCone || table.has("file")) {
    table.fail("surface_velocity", "belongs to flat walls");
  }
  if (wall.shape != Wall<D>::Shape::kSegment) {
    through = surface->dot(wall.normal) * wall.normal;
  } else if (const Vec<D> side = wall.b - wall.a; side.norm() > 0) {
    through = *surface - surface->dot(side) / side.squaredNorm() * side;
  }
  if (!(through.norm() <= 1e-9 * surface->norm())) {
    table.fail("surface_velocity", "must lie along the wall ('velocity' moves the wall itself)");
  }
  wall.belt = *surface - through;
}

/// Friction that differs along and across the grain of a plate.
template <int D>
void read_grain(const SceneTable& table, Wall<D>& wall) {
  const auto grain = table.maybe_vec<D>("grain");
  if (!grain) {
    if (table.has("grain_ratio")) table.fail("grain_ratio", "needs 'grain', a direction");
    return;
  }
  if (D == 2) table.fail("grain", "needs a second tangent: it belongs to scenes in 3D");
  if (wall.is_circle() || wall.shape == Wall<D>::Shape::kCone || table.has("file")) {
    table.fail("grain", "belongs to flat walls");
  }
  const Vec<D> along = *grain - grain->dot(wall.normal) * wall.normal;
  if (!(along.norm() > 1e-9 * grain->norm())) table.fail("grain", "must not be normal to the wall");
  wall.grain = along.normalized();
  wall.grain_ratio = table.positive("grain_ratio");
}

/// Times of start, stop and removal, and the factor of the motion.
template <int D>
void read_times(const SceneTable& table, Wall<D>& wall) {
  wall.time_factor = read_time_factor(table);
  const bool moves =
      wall.motion != Wall<D>::Motion::kFixed || wall.spin != 0 || !wall.belt.isZero(0);
  for (const char* key : {"starts", "stops", "times", "frequency"}) {
    if (table.has(key) && !moves)
      table.fail(key, "belongs to a wall that moves, is driven, turns or is a belt");
  }
  table.read_period(wall.starts, wall.stops);
  wall.removed = table.number("removed", wall.removed);
  if (!(wall.removed > 0)) table.fail("removed", "expected a positive number");
}

}  // namespace

TimeFactor read_time_factor(const SceneTable& table) {
  TimeFactor factor{.times = table.numbers("times"), .factors = table.numbers("factors")};
  if (table.has("frequency")) factor.frequency = table.positive("frequency");
  factor.phase = table.number("phase", 0);
  if (table.has("phase") && factor.frequency == 0) table.fail("phase", "belongs to a frequency");
  const char* key = factor.frequency > 0 ? "frequency" : factor.times.empty() ? "factors" : "times";
  if (auto e = check_time_factor(factor); !e.empty()) table.fail(key, e);
  return factor;
}

template <int D>
int material_index(const Scene<D>& scene, const SceneTable& table, std::string_view key) {
  const std::string name = table.word(key, scene.materials.front());
  return static_cast<int>(table.index_of(key, "material", name, scene.materials));
}

template <int D>
Wall<D> read_wall(const SceneTable& table, const Scene<D>& scene, std::size_t index) {
  Wall<D> wall;
  wall.name = table.word("name", fmt::format("wall{}", index));
  read_shape(table, wall);
  wall.material = material_index(scene, table, "material");
  if (table.has("force") || table.has("direction") || table.has("mass")) {
    read_drive(table, wall);
  } else if (const auto velocity = table.maybe_vec<D>("velocity")) {
    wall.motion = Wall<D>::Motion::kMoving;
    wall.v = *velocity;
  }
  read_belt(table, wall);
  read_grain(table, wall);
  read_times(table, wall);
  return wall;
}

template int material_index(const Scene<2>&, const SceneTable&, std::string_view);
template int material_index(const Scene<3>&, const SceneTable&, std::string_view);
template Wall<2> read_wall(const SceneTable&, const Scene<2>&, std::size_t);
template Wall<3> read_wall(const SceneTable&, const Scene<3>&, std::size_t);

}  // namespace bipot
