#include <fmt/format.h>

#include <cmath>

#include "bench/compare/case_parts.h"

namespace bipot {
namespace {

void add_tower(std::vector<ExtremeCase>& cases, const std::string& name, const std::string& what,
               const Scene<2>& scene) {
  cases.push_back(
      {.name = name,
       .what = what,
       .known =
           "at rest every contact carries the weight above it, h g Σ m, without friction; W is "
           "regular, so that these impulses are the only ones",
       .problem = step_of(scene),
       .true_error = against(tower_impulses(scene)),
       .solution = [scene] { return tower_impulses(scene); }});
}

/// A disk on a plane inclined by `angle`: W_nn = 1/m, W_tt = 1/m + a²/I, free velocities -h g cos
/// and h g sin. It rolls with s_t = h m g sin / (1 + m a²/I) if that is below mu s_n, else it
/// slides with s_t = mu s_n.
void add_rolling(std::vector<ExtremeCase>& cases, const std::string& name, double inertia,
                 double mu, double slope) {
  Scene<2> scene = empty_scene(mu);
  const double angle = std::atan(slope);
  scene.gravity = 9.81 * Vec2(std::sin(angle), -std::cos(angle));
  scene.bodies = {round_body<2>(Vec2(0, 0.5), 0.5, 2)};
  Disk& d = scene.bodies[0];
  d.inertia = inertia * 0.5 * d.mass * d.radius * d.radius;
  scene.walls = {flat_floor<2>()};
  const double normal = scene.step * 2 * 9.81 * std::cos(angle);
  const double rolling = normal * slope / (1 + 2 / inertia);
  cases.push_back(
      {.name = name,
       .what = fmt::format("a disk with {:g} times the inertia of a homogeneous one on a plane of "
                           "slope {:g}, mu = {:g}",
                           inertia, slope, mu),
       .known = rolling < mu * normal ? "it rolls: s_t = h m g sin / (1 + m a²/I)"
                                      : "it slides: s_t = mu s_n",
       .problem = step_of(scene),
       .true_error = [normal, rolling, mu](const Vector& s, const Vector&) {
         const double friction = std::min(rolling, mu * normal);
         return std::hypot(s[0] - normal, std::abs(s[1]) - friction) / normal;
       }});
}

}  // namespace

void add_mass_cases(std::vector<ExtremeCase>& cases) {
  for (const double ratio : {1e2, 1e6, 1e12}) {
    const std::vector<double> light(7, 1.0);
    std::vector<double> top = light, bottom = light, alternating;
    top.push_back(ratio);
    bottom.insert(bottom.begin(), ratio);
    for (int k = 0; k < 8; ++k) alternating.push_back(k % 2 == 0 ? 1 : ratio);
    const std::string label = fmt::format("1e{:.0f}", std::log10(ratio));
    add_tower(cases, "heavy_on_light_" + label,
              "a tower of 7 disks of 1 kg, on top one of " + label + " kg", tower(top, {0.5}));
    add_tower(cases, "light_on_heavy_" + label, "the same with the heavy disk at the bottom",
              tower(bottom, {0.5}));
    add_tower(cases, "alternating_" + label, "a tower of 8 disks, 1 and " + label + " kg in turn",
              tower(alternating, {0.5}));
  }
  add_tower(cases, "radii_1e3", "a tower of 8 disks with radii 0.5 m and 0.5 mm in turn, 1 kg each",
            tower(std::vector<double>(8, 1.0), {0.5, 0.5e-3}));
  add_tower(cases, "radii_and_masses", "the same, masses as the squares of the radii",
            tower({1, 1e-6, 1, 1e-6, 1, 1e-6, 1, 1e-6}, {0.5, 0.5e-3}));
  add_rolling(cases, "inertia_0.01_rolls", 0.01, 0.3, 10);
  add_rolling(cases, "inertia_100_slides", 100, 0.3, 0.5);
  add_rolling(cases, "inertia_100_rolls", 100, 0.6, 0.5);
}

}  // namespace bipot
