#include "core/scene_files/scene_groups.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "core/scene_files/lmgc90_bodies.h"

namespace bipot {
namespace {

/// x with Φ(x) = p for the normal distribution, by bisection.
double normal_quantile(double p) {
  double low = -40, high = 40;
  for (int k = 0; k < 64; ++k) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::numbers::sqrt2) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// The quantile of a distribution that rows (radius, share up to it) describe.
double table_quantile(const std::vector<std::vector<double>>& rows, double p) {
  std::size_t k = 1;
  while (k + 1 < rows.size() && rows[k][1] < p) ++k;
  const double part = (p - rows[k - 1][1]) / (rows[k][1] - rows[k - 1][1]);
  return rows[k - 1][0] + part * (rows[k][0] - rows[k - 1][0]);
}

std::vector<std::vector<double>> read_passing(const SceneTable& table) {
  const std::vector<std::vector<double>> rows = table.rows("passing", 2);
  bool sound = rows.size() >= 2 && rows[0][0] > 0 && rows[0][1] == 0 && rows.back()[1] == 1;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    sound = sound && rows[k][0] >= rows[k - 1][0] && rows[k][1] > rows[k - 1][1];
  }
  if (!sound)
    table.fail("passing", "expected rows [radius, share], both rising, shares from 0 to 1");
  return rows;
}

}  // namespace

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

std::vector<RadiusClass> read_radii(const SceneTable& table, int count) {
  const bool lognormal = table.has("lognormal"), passing = table.has("passing");
  if (!lognormal && !passing) return read_radius_classes(table);
  if (table.has("radii") || (lognormal && passing)) {
    table.fail(lognormal ? "lognormal" : "passing", "give one of radii, lognormal and passing");
  }
  std::function<double(double)> quantile;
  if (lognormal) {
    const std::vector<double> of = table.numbers("lognormal");
    if (of.size() != 2 || !(of[0] > 0) || !(of[1] >= 0) || !(of[1] <= 2)) {
      table.fail("lognormal", "expected [median > 0, sigma of the logarithm in [0, 2]]");
    }
    quantile = [of](double p) { return of[0] * std::exp(of[1] * normal_quantile(p)); };
  } else {
    quantile = [rows = read_passing(table)](double p) { return table_quantile(rows, p); };
  }
  std::vector<RadiusClass> classes;
  for (int k = 0; k < count; ++k) classes.push_back({quantile((k + 0.5) / count), 1.0});
  return classes;
}

void require_possible(const SceneTable& table, std::string_view key, double count,
                      std::string_view bodies) {
  constexpr double kMost = 1e7;
  if (count > kMost) {
    table.fail(key, fmt::format("{:.3g} {}, at most {:g} are possible", count, bodies, kMost));
  }
}

std::vector<PositionRow> read_named_positions(const SceneTable& table, int dim,
                                              std::string& caution) {
  const std::string name = table.word("file", "");
  if (name.empty()) table.fail("file", "is missing: name a CSV file with x, y and radius");
  const std::filesystem::path path = table.folder() / name;
  std::map<std::string, int> left_out;
  const std::vector<PositionRow> rows = path.extension() == ".DAT"
                                            ? read_lmgc90_bodies(path, dim, &left_out)
                                            : read_positions(path, dim);
  std::string others;
  for (const auto& [contactor, count] : left_out) {
    others += fmt::format("{} {} {}", others.empty() ? ", left out:" : ",", count, contactor);
  }
  if (rows.empty()) {
    table.fail("file", fmt::format("{} has no {}{}", name, dim == 2 ? "disk" : "sphere", others));
  }
  if (!others.empty()) {
    caution +=
        fmt::format("{}{}: {} read{}", caution.empty() ? "" : "; ", name, rows.size(), others);
  }
  require_possible(table, "file", static_cast<double>(rows.size()), "bodies");
  return rows;
}

GroupMass read_group_mass(const SceneTable& table, bool with_inertia) {
  GroupMass group{table.maybe_positive("mass"), table.maybe_positive("density")};
  if (with_inertia) group.inertia = table.maybe_positive("inertia");
  if (group.density.has_value() == group.mass.has_value()) {
    table.fail("mass", "give either mass [kg] or density [kg/m³]");
  }
  return group;
}

}  // namespace bipot
