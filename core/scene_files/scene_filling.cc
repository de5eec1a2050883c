#include "core/scene_files/scene_filling.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "core/scene/generators.h"
#include "core/scene/wall_room.h"
#include "core/scene_files/scene_groups.h"

namespace bipot {
namespace {

/// The room of the walls that `inside` names, one or several; without the key all space.
template <int D>
WallRoom<D> read_room(const SceneTable& table, const Scene<D>& scene) {
  if (!table.has("inside")) return {};
  const std::vector<std::string> wanted =
      table.is_array("inside") ? table.words("inside") : std::vector{table.word("inside", "")};
  const std::vector<std::string> names = names_of(scene.walls);
  for (const std::string& name : wanted) table.index_of("inside", "wall", name, names);
  std::vector<Wall<D>> walls;
  for (const Wall<D>& wall : scene.walls) {
    if (std::find(wanted.begin(), wanted.end(), wall.name) != wanted.end()) walls.push_back(wall);
  }
  try {
    return room_within(std::move(walls));
  } catch (const std::invalid_argument& e) {
    table.fail("inside", e.what());
  }
}

/// Where a random filling goes.
template <int D>
struct FillingPlace {
  Vec<D> corner;    ///< lower left one                                                       [m]
  Vec<D - 1> base;  ///< width, in 3D also depth                                              [m]
  FillingBounds<D> bounds;
};

template <int D>
FillingPlace<D> read_filling_place(const SceneTable& table, const Scene<D>& scene) {
  constexpr const char* kSizes[] = {"width", D == 2 ? "height" : "depth", "height"};
  FillingPlace<D> place;
  const WallRoom<D> room = read_room(table, scene);
  const auto corner = table.maybe_vec<D>("corner");
  const bool within = !room.walls.empty();
  Vec<D> upper;
  for (int k = 0; k < D; ++k) {
    place.corner[k] = corner ? (*corner)[k] : within ? room.box.lower[k] : 0.0;
    if (!std::isfinite(place.corner[k])) {
      table.fail("corner", "is missing: the walls of 'inside' do not bound the filling from there");
    }
    const bool given = table.has(kSizes[k]);
    // Without walls a filling is as deep as it is wide, and grows upwards without end.
    const double size = given                  ? table.positive(kSizes[k])
                        : within || k == D - 1 ? kInfinity
                        : k > 0                ? place.base[0]
                                               : table.positive(kSizes[k]);
    upper[k] = place.corner[k] + size;
    double length = size;
    if (within) {
      place.corner[k] = std::max(place.corner[k], room.box.lower[k]);
      length = std::min(upper[k], room.box.upper[k]) - place.corner[k];
    }
    if (k == D - 1) {
      place.bounds.height = length;
    } else if (std::isfinite(length)) {
      place.base[k] = length;
    } else {
      table.fail(kSizes[k], "is missing: the walls of 'inside' do not bound the filling");
    }
  }
  if (within) {
    place.bounds.holds = [room](const Vec<D>& x, double radius) { return room.holds(x, radius); };
  }
  return place;
}

}  // namespace

std::uint64_t read_seed(const SceneTable& table) {
  const int seed = table.integer("seed", 1);
  if (seed < 0) table.fail("seed", "expected a non-negative integer");
  return static_cast<std::uint64_t>(seed);
}

template <int D>
std::vector<Body<D>> read_filling(const SceneTable& table, const Scene<D>& scene,
                                  std::string_view kind, std::optional<double> radius) {
  const std::uint64_t seed = read_seed(table);
  const int count = table.natural("count");
  require_possible(table, "count", count, kind);
  const std::vector<RadiusClass> classes =
      radius ? std::vector<RadiusClass>{{*radius, 1}} : read_radii(table, count);
  const FillingPlace<D> place = read_filling_place(table, scene);
  const double spacing = table.number("spacing", 0.1);
  try {
    if constexpr (D == 2) {
      return random_filling(count, classes, place.base[0], spacing, seed, place.corner,
                            place.bounds);
    } else {
      return random_spheres(count, classes, place.base, spacing, seed, place.corner, place.bounds);
    }
  } catch (const std::invalid_argument& e) {
    table.fail("arrangement", e.what());
  }
}

template std::vector<Disk> read_filling(const SceneTable&, const Scene<2>&, std::string_view,
                                        std::optional<double>);
template std::vector<Sphere> read_filling(const SceneTable&, const Scene<3>&, std::string_view,
                                          std::optional<double>);

}  // namespace bipot
