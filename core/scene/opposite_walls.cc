#include "core/scene/opposite_walls.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace bipot {

namespace {

/// A driven half-plane or segment that presses straight ahead.
template <int D>
bool presses(const Wall<D>& wall) {
  constexpr double kStraight = 1e-9;
  if (wall.motion != Wall<D>::Motion::kDriven || wall.is_circle() || wall.is_surface())
    return false;
  if (!wall.time_factor.constant()) return false;  // its force changes
  if (wall.shape == Wall<D>::Shape::kHalfPlane) {
    return wall.direction.dot(wall.normal) > 1 - kStraight;
  }
  const Vec<D> along = wall.b - wall.a;
  return std::abs(wall.direction.dot(along)) <= kStraight * along.norm();
}

/// Two that press against each other. Of two segments, each lies before the other.
template <int D>
bool face_each_other(const Wall<D>& a, const Wall<D>& b) {
  if (!presses(a) || !presses(b) || a.direction.dot(b.direction) > 1e-9 - 1) return false;
  if (a.direction.dot(b.a - a.a) <= 0) return false;
  using Shape = typename Wall<D>::Shape;
  if (a.shape != Shape::kSegment || b.shape != Shape::kSegment) return true;
  const Vec<D> along = b.b - b.a;
  const auto place = [&](const Vec<D>& x) { return along.dot(x - b.a) / along.squaredNorm(); };
  return std::max(place(a.a), place(a.b)) > 0 && std::min(place(a.a), place(a.b)) < 1;
}

}  // namespace

template <int D>
std::string unbalanced_walls(const Scene<D>& scene) {
  constexpr double kBalanced = 1e-3;  // of the larger force
  if (scene.has_gates() || scene.tilt.rate != 0) return {};
  double mass = 0;
  for (const Body<D>& body : scene.bodies) mass += body.mass;
  for (const Cluster<D>& cluster : scene.clusters.bodies) mass += cluster.mass;
  std::string text;
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    for (std::size_t j = i + 1; j < scene.walls.size(); ++j) {
      const Wall<D>&a = scene.walls[i], &b = scene.walls[j];
      if (!face_each_other(a, b)) continue;
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
