#include "core/scene/wall_pieces.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/scene/triangle_mesh.h"

namespace bipot {
namespace {

/// Extent of the corners of a box along a direction, from a point.
struct Reach {
  double first = kInfinity, last = -kInfinity;
};

Reach reach_along(const Box<3>& box, const Vec3& point, const Vec3& direction) {
  Reach reach;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 x = box.lower;
    for (int k = 0; k < 3; ++k) {
      if ((corner >> k & 1) != 0) x[k] = box.upper[k];
    }
    const double at = (x - point).dot(direction);
    reach.first = std::min(reach.first, at);
    reach.last = std::max(reach.last, at);
  }
  return reach;
}

std::array<Vec3, 4> plane_corners(const Wall<3>& wall, const Box<3>& box) {
  // Along the axes of space if the plane is: its piece of a box is then a face of the box.
  int least = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(wall.normal[k]) < std::abs(wall.normal[least]) - 1e-12) least = k;
  }
  const Vec3 axis = Vec3::Unit(least);
  const Vec3 t = (axis - axis.dot(wall.normal) * wall.normal).normalized();
  const Vec3 s = wall.normal.cross(t);
  const Reach along = reach_along(box, wall.a, t), across = reach_along(box, wall.a, s);
  return {wall.a + along.first * t + across.first * s, wall.a + along.last * t + across.first * s,
          wall.a + along.last * t + across.last * s, wall.a + along.first * t + across.last * s};
}

}  // namespace

std::size_t num_wall_pieces(std::span<const Wall<3>> walls) {
  std::size_t pieces = 0;
  for (const Wall<3>& w : walls) {
    pieces += w.shape == Wall<3>::Shape::kMesh  ? w.mesh->triangles.size()
              : w.is_circle() || w.is_surface() ? to_size(kPrismSides)
                                                : 1;
  }
  return pieces;
}

std::vector<WallPiece> wall_pieces(std::span<const Wall<3>> walls, const Box<3>& box) {
  std::vector<WallPiece> pieces;
  for (std::size_t k = 0; k < walls.size(); ++k) {
    const Wall<3>& wall = walls[k];
    const int index = static_cast<int>(k);
    if (wall.shape == Wall<3>::Shape::kMesh) {
      const double size = wall.present ? 1 : 0;
      for (const auto& [p, q, r] : wall.mesh->triangles) {
        pieces.push_back(
            {index, {wall.a + size * p, wall.a + size * q, wall.a + size * r, wall.a + size * r}});
      }
      continue;
    }
    if (!wall.is_circle() && !wall.is_surface()) {
      pieces.push_back({index, wall.present ? plane_corners(wall, box)
                                            : std::array{wall.a, wall.a, wall.a, wall.a}});
      continue;
    }
    const bool cone = wall.is_surface();
    const Vec3 axis = cone ? Vec3((wall.b - wall.a).normalized()) : wall.normal;
    const auto frame = contact_frame<3>(axis);
    const Reach length =
        cone ? Reach{0, (wall.b - wall.a).norm()} : reach_along(box, wall.a, wall.normal);
    const auto edge = [&](int side, double at) {
      // The last corner is the first one to the bit: a cut through it meets one of two sides.
      const double angle = 2 * std::numbers::pi * (side % kPrismSides) / kPrismSides;
      const double radius = !wall.present               ? 0
                            : cone && at == length.last ? wall.radius_b
                                                        : wall.radius;
      return Vec3(wall.a + at * axis +
                  radius * (std::cos(angle) * frame[1] + std::sin(angle) * frame[2]));
    };
    for (int side = 0; side < kPrismSides; ++side) {
      pieces.push_back({index,
                        {edge(side, length.first), edge(side + 1, length.first),
                         edge(side + 1, length.last), edge(side, length.last)}});
    }
  }
  return pieces;
}

Box<3> view_box(std::span<const Sphere> spheres, std::span<const Wall<3>> walls) {
  Box<3> box;
  for (const Sphere& s : spheres) box.include(s.x, s.radius);
  if (!box.empty()) return box;
  for (const Wall<3>& w : walls) box.include(w.a);
  if (box.empty()) box.include(Vec3::Zero());
  const double width = box.size().maxCoeff();
  box.widen(width > 0 ? 0.1 * width : 1.0);
  return box;
}

}  // namespace bipot
