#include "core/scene/opposite_walls.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace bipot {

template <int D>
std::string unbalanced_walls(const Scene<D>& scene) {
  constexpr double kBalanced = 1e-3;  // of the larger force
  if (scene.has_gates() || scene.tilt.rate != 0) return {};
  double mass = 0;
  for (const Body<D>& body : scene.bodies) mass += body.mass;
  for (const Cluster& cluster : scene.clusters.bodies) mass += cluster.mass;
  const auto presses = [](const Wall<D>& wall) {
    return wall.motion == Wall<D>::Motion::kDriven && wall.shape == Wall<D>::Shape::kHalfPlane &&
           wall.direction.dot(wall.normal) > 1 - 1e-9;
  };
  std::string text;
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    for (std::size_t j = i + 1; j < scene.walls.size(); ++j) {
      const Wall<D>&a = scene.walls[i], &b = scene.walls[j];
      if (!presses(a) || !presses(b) || a.normal.dot(b.normal) > 1e-9 - 1) continue;
      const double net = a.force - b.force + mass * scene.gravity.dot(a.direction);
      if (std::abs(net) <= kBalanced * std::max(std::abs(a.force), std::abs(b.force))) continue;
      text += fmt::format(
          "walls '{}' and '{}' press with {:g} N and {:g} N against each other: {:.3g} N{} "
          "accelerate the whole sample\n",
          a.name, b.name, a.force, b.force, std::abs(net),
          scene.gravity.dot(a.direction) != 0 ? ", weight included," : "");
    }
  }
  return text;
}

template std::string unbalanced_walls(const Scene<2>&);
template std::string unbalanced_walls(const Scene<3>&);

}  // namespace bipot
