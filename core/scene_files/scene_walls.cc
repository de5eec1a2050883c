#include "core/scene_files/scene_tables.h"

namespace bipot {
namespace {

/// Half-plane, segment or circle.
void read_shape(const SceneTable& table, Wall<2>& wall) {
  const auto point = table.maybe_vec2("point"), normal = table.maybe_vec2("normal");
  const auto from = table.maybe_vec2("from"), to = table.maybe_vec2("to");
  const auto center = table.maybe_vec2("center");
  if (point && normal && !from && !to && !center) {
    wall.a = *point;
    if (!(normal->norm() > 0)) table.fail("normal", "must not be zero");
    wall.normal = normal->normalized();
  } else if (from && to && !point && !normal && !center) {
    wall.shape = Wall<2>::Shape::kSegment;
    wall.a = *from;
    wall.b = *to;
  } else if (center && !point && !normal && !from && !to) {
    const bool hollow = table.boolean("hollow", false);
    wall.shape = hollow ? Wall<2>::Shape::kHollowCircle : Wall<2>::Shape::kSolidCircle;
    wall.a = *center;
    wall.radius = table.positive("radius");
    wall.spin = table.number("spin", 0);
  } else {
    table.fail(
        "point",
        "give point and normal (a half-plane), from and to (a segment), or center and radius "
        "(a circle)");
  }
}

/// Half-space or cylinder.
void read_shape(const SceneTable& table, Wall<3>& wall) {
  const auto point = table.maybe_vec<3>("point"), normal = table.maybe_vec<3>("normal");
  const auto center = table.maybe_vec<3>("center");
  if (point && normal && !center) {
    wall.a = *point;
    if (!(normal->norm() > 0)) table.fail("normal", "must not be zero");
    wall.normal = normal->normalized();
  } else if (center && !point && !normal) {
    const bool hollow = table.boolean("hollow", false);
    wall.shape = hollow ? Wall<3>::Shape::kHollowCircle : Wall<3>::Shape::kSolidCircle;
    wall.a = *center;
    const auto axis = table.maybe_vec<3>("axis");
    if (!axis) table.fail("axis", "is missing for a cylinder");
    if (!(axis->norm() > 0)) table.fail("axis", "must not be zero");
    wall.normal = axis->normalized();
    wall.radius = table.positive("radius");
    wall.spin = table.number("spin", 0);
  } else {
    table.fail("point",
               "give point and normal (a half-space), or center, axis and radius (a cylinder)");
  }
}

/// Driven by a force. A velocity moves it across that direction.
template <int D>
void read_drive(const SceneTable& table, Wall<D>& wall) {
  const auto force = table.maybe_number("force"), mass = table.maybe_number("mass");
  const auto direction = table.maybe_vec<D>("direction");
  if (!force || !mass) table.fail("force", "a driven wall needs force [N] and mass [kg]");
  wall.motion = Wall<D>::Motion::kDriven;
  wall.force = *force;
  wall.mass = *mass;
  if (!direction && wall.shape != Wall<D>::Shape::kHalfPlane) {
    table.fail("direction", D == 2 ? "is missing for a driven segment or circle"
                                   : "is missing for a driven cylinder");
  }
  const Vec<D> axis = direction ? *direction : wall.normal;
  if (!(axis.norm() > 0)) table.fail("direction", "must not be zero");
  wall.direction = axis.normalized();
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
  if (wall.shape == Wall<D>::Shape::kHalfPlane) {
    through = surface->dot(wall.normal) * wall.normal;
  } else if (const Vec<D> side = wall.b - wall.a; side.norm() > 0) {
    through = *surface - surface->dot(side) / side.squaredNorm() * side;
  }
  if (!(through.norm() <= 1e-9 * surface->norm())) {
    table.fail("surface_velocity", "must lie along the wall ('velocity' moves the wall itself)");
  }
  wall.belt = *surface - through;
}

/// Times of start, stop and removal.
template <int D>
void read_times(const SceneTable& table, Wall<D>& wall) {
  const bool moves =
      wall.motion != Wall<D>::Motion::kFixed || wall.spin != 0 || !wall.belt.isZero(0);
  for (const char* key : {"starts", "stops"}) {
    if (table.has(key) && !moves)
      table.fail(key, "belongs to a wall that moves, is driven, turns or is a belt");
  }
  wall.starts = table.number("starts", wall.starts);
  if (!(wall.starts >= 0)) table.fail("starts", "expected a number >= 0");
  wall.stops = table.number("stops", wall.stops);
  if (!(wall.stops > wall.starts)) table.fail("stops", "must be later than starts");
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
  const auto it = std::find(scene.materials.begin(), scene.materials.end(), name);
  if (it == scene.materials.end()) {
    table.fail(key, unknown_name_message("material", name, scene.materials));
  }
  return static_cast<int>(it - scene.materials.begin());
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
  read_times(table, wall);
  wall.time_factor = read_time_factor(table);
  const bool moves =
      wall.motion != Wall<D>::Motion::kFixed || wall.spin != 0 || !wall.belt.isZero(0);
  if (!wall.time_factor.constant() && !moves) {
    table.fail(table.has("times") ? "times" : "frequency",
               "belongs to a wall that moves, is driven, turns or is a belt");
  }
  return wall;
}

template int material_index(const Scene<2>&, const SceneTable&, std::string_view);
template int material_index(const Scene<3>&, const SceneTable&, std::string_view);
template Wall<2> read_wall(const SceneTable&, const Scene<2>&, std::size_t);
template Wall<3> read_wall(const SceneTable&, const Scene<3>&, std::size_t);

}  // namespace bipot
