#include "core/scene_files/scene_groups.h"

#include <fmt/format.h>

namespace bipot {

std::vector<RadiusClass> read_radius_classes(const SceneTable& table) {
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

void require_possible(const SceneTable& table, std::string_view key, double count,
                      std::string_view bodies) {
  constexpr double kMost = 1e7;
  if (count > kMost) {
    table.fail(key, fmt::format("{:.3g} {}, at most {:g} are possible", count, bodies, kMost));
  }
}

std::vector<PositionRow> read_named_positions(const SceneTable& table, int dim) {
  const std::string name = table.word("file", "");
  if (name.empty()) table.fail("file", "is missing: name a CSV file with x, y and radius");
  const std::vector<PositionRow> rows = read_positions(table.folder() / name, dim);
  require_possible(table, "file", static_cast<double>(rows.size()), "bodies");
  return rows;
}

GroupMass read_group_mass(const SceneTable& table) {
  GroupMass group{table.maybe_number("mass"), table.maybe_number("density"),
                  table.maybe_number("inertia")};
  if (group.density.has_value() == group.mass.has_value()) {
    table.fail("mass", "give either mass [kg] or density [kg/m³]");
  }
  if (group.density && !(*group.density > 0)) table.fail("density", "expected a positive number");
  if (group.mass && !(*group.mass > 0)) table.fail("mass", "expected a positive number");
  return group;
}

}  // namespace bipot
