#include "core/files/scene_spheres.h"

#include <numbers>

#include "core/files/scene_walls.h"
#include "core/scene/sphere_generators.h"

namespace bipot {
namespace {

std::vector<RadiusClass> sphere_classes(const SceneTable& table) {
  const std::vector<double> radii = table.numbers("radii");
  std::vector<double> fractions = table.numbers("fractions");
  if (radii.empty()) table.fail("radii", "is missing");
  if (fractions.empty()) fractions.assign(radii.size(), 1.0);
  if (fractions.size() != radii.size()) {
    table.fail("fractions", fmt::format("{} entries for {} radii", fractions.size(), radii.size()));
  }
  std::vector<RadiusClass> classes;
  for (std::size_t k = 0; k < radii.size(); ++k) classes.push_back({radii[k], fractions[k]});
  return classes;
}

std::vector<Sphere> read_arrangement(const SceneTable& table) {
  static const std::vector<std::string> kArrangements = {"single", "cubic", "pyramid", "random"};
  const std::string arrangement = table.one_of("arrangement", "single", kArrangements);
  if (arrangement == "single") {
    Sphere sphere;
    const auto position = table.maybe_vec<3>("position");
    if (!position) table.fail("position", "is missing");
    sphere.x = *position;
    sphere.radius = table.positive("radius");
    return {sphere};
  }
  const Vec3 corner = table.maybe_vec<3>("corner").value_or(Vec3::Zero());
  if (arrangement == "random") {
    const int seed = table.integer("seed", 1);
    if (seed < 0) table.fail("seed", "expected a non-negative integer");
    const int count = table.natural("count");
    const double width = table.positive("width");
    const double depth = table.has("depth") ? table.positive("depth") : width;
    try {
      return random_spheres(count, sphere_classes(table), Vec2(width, depth),
                            table.number("spacing", 0.1), static_cast<std::uint64_t>(seed), corner);
    } catch (const std::invalid_argument& e) {
      table.fail("arrangement", e.what());
    }
  }
  const double radius = table.positive("radius");
  const int rows = table.natural("rows");
  if (arrangement == "pyramid") return sphere_pyramid(rows, radius, corner);
  return cubic_lattice(table.natural("columns"), rows, table.natural("layers"), radius, corner);
}

}  // namespace

std::vector<Sphere> read_spheres(const SceneTable& table, const SceneIn<3>& scene) {
  std::vector<Sphere> spheres = read_arrangement(table);
  const auto density = table.maybe_number("density"), mass = table.maybe_number("mass");
  if (density.has_value() == mass.has_value()) {
    table.fail("mass", "give either mass [kg] or density [kg/m³]");
  }
  if (density && !(*density > 0)) table.fail("density", "expected a positive number");
  if (mass && !(*mass > 0)) table.fail("mass", "expected a positive number");
  const auto inertia = table.maybe_number("inertia");
  const Vec3 v = table.maybe_vec<3>("velocity").value_or(Vec3::Zero());
  const Vec3 spin = table.maybe_vec<3>("spin").value_or(Vec3::Zero());
  const int material = material_index(scene, table, "material");
  for (Sphere& s : spheres) {
    const double volume = 4 * std::numbers::pi / 3 * s.radius * s.radius * s.radius;
    s.mass = mass ? *mass : *density * volume;
    s.inertia = inertia ? *inertia : 0.4 * s.mass * s.radius * s.radius;
    s.v = v;
    s.spin = spin;
    s.material = material;
  }
  return spheres;
}

}  // namespace bipot
