#include "core/scene/wall_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/scene/contact_detection.h"

namespace bipot {
namespace {

/// True if a ray from x to the right crosses the segment.
bool ray_crosses(const Vec2& x, const Vec2& a, const Vec2& b) {
  if ((a[1] > x[1]) == (b[1] > x[1])) return false;
  return x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
}

/// Within the closed lines of the segments (an odd number of crossings), or without any segments.
bool within_segments(const std::vector<Wall<2>>& walls, const Vec2& x) {
  bool any = false, within = false;
  for (const Wall<2>& wall : walls) {
    if (wall.shape != Wall<2>::Shape::kSegment) continue;
    any = true;
    within ^= ray_crosses(x, wall.a, wall.b);
  }
  return within || !any;
}
bool within_segments(const std::vector<Wall<3>>&, const Vec3&) { return true; }

/// Each end of a segment is that of one other.
void require_closed(const std::vector<Wall<2>>& walls) {
  std::vector<Vec2> ends;
  for (const Wall<2>& wall : walls) {
    if (wall.shape == Wall<2>::Shape::kSegment) ends.insert(ends.end(), {wall.a, wall.b});
  }
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const double near = 1e-9 * (ends[i] - ends[i ^ 1]).norm();
    const auto meets = std::count_if(ends.begin(), ends.end(), [&](const Vec2& other) {
      return (other - ends[i]).norm() <= near;
    });
    if (meets == 2) continue;
    throw std::invalid_argument(fmt::format(
        "its segments do not make a closed line: {} walls meet at ({:g}, {:g}) m, not 2; "
        "close it, or give corner, width and height",
        meets, ends[i][0], ends[i][1]));
  }
}
void require_closed(const std::vector<Wall<3>>&) {}

/// Narrows the box to what lies before the wall, inside the hollow circle or cylinder.
template <int D>
void narrow(const Wall<D>& wall, Box<D>& box) {
  constexpr double kAlong = 1e-12;
  for (int k = 0; k < D; ++k) {
    if (wall.shape == Wall<D>::Shape::kHollowCircle) {
      if (D == 3 && std::abs(wall.normal[k]) > kAlong) continue;  // endless there
      box.lower[k] = std::max(box.lower[k], wall.a[k] - wall.radius);
      box.upper[k] = std::min(box.upper[k], wall.a[k] + wall.radius);
    } else if (wall.shape == Wall<D>::Shape::kHalfPlane) {
      if (wall.normal[k] > 1 - kAlong) box.lower[k] = std::max(box.lower[k], wall.a[k]);
      if (wall.normal[k] < kAlong - 1) box.upper[k] = std::min(box.upper[k], wall.a[k]);
    }
  }
}

}  // namespace

template <int D>
bool WallRoom<D>::holds(const Vec<D>& x, double radius) const {
  Body<D> body;
  body.x = x;
  body.radius = radius;
  const double rounding = 1e-12 * (radius + x.cwiseAbs().maxCoeff());
  std::vector<Contact<D>> overlaps;
  for (const Wall<D>& wall : walls) find_wall_contact<D>(body, 0, wall, 1, -rounding, overlaps);
  return overlaps.empty() && within_segments(walls, x);
}

template <int D>
WallRoom<D> room_within(std::vector<Wall<D>> walls) {
  if (walls.empty()) throw std::invalid_argument("no wall has this name");
  for (const Wall<D>& wall : walls) {
    if (!wall.is_surface()) continue;
    throw std::invalid_argument(
        fmt::format("'{}' bounds no filling: give corner, width and height", wall.name));
  }
  const bool outside = std::all_of(walls.begin(), walls.end(), [](const Wall<D>& wall) {
    return wall.shape == Wall<D>::Shape::kSolidCircle;
  });
  if (outside) {
    throw std::invalid_argument(fmt::format(
        "'{}' is solid: bodies lie outside of it, those inside need hollow = true", walls[0].name));
  }
  require_closed(walls);
  WallRoom<D> room{.walls = std::move(walls)};
  Box<D> of_segments;
  for (const Wall<D>& wall : room.walls) {
    narrow(wall, room.box);
    if (wall.shape != Wall<D>::Shape::kSegment) continue;
    of_segments.include(wall.a);
    of_segments.include(wall.b);
  }
  if (!of_segments.empty()) {
    room.box.lower = room.box.lower.cwiseMax(of_segments.lower);
    room.box.upper = room.box.upper.cwiseMin(of_segments.upper);
  }
  return room;
}

template struct WallRoom<2>;
template struct WallRoom<3>;
template WallRoom<2> room_within(std::vector<Wall<2>>);
template WallRoom<3> room_within(std::vector<Wall<3>>);

}  // namespace bipot
