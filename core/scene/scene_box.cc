#include "core/scene/scene_box.h"

#include <algorithm>

namespace bipot {
namespace {

/// The point of a wall nearest to x.
Vec2 nearest_point(const Wall<2>& wall, const Vec2& x) {
  if (wall.shape == Wall<2>::Shape::kHalfPlane) {
    return x - (x - wall.a).dot(wall.normal) * wall.normal;
  }
  if (wall.is_circle()) {
    const Vec2 d = x - wall.a;
    const double distance = d.norm();
    return wall.a + wall.radius * (distance > 0 ? Vec2(d / distance) : Vec2(1, 0));
  }
  const Vec2 along = wall.b - wall.a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? (x - wall.a).dot(along) / length2 : 0.0;
  return wall.a + std::clamp(t, 0.0, 1.0) * along;
}

/// Whether x lies behind another half-plane, where nothing of a wall is drawn.
bool is_hidden(const Vec2& x, const Wall<2>& wall, std::span<const Wall<2>> walls) {
  return std::any_of(walls.begin(), walls.end(), [&](const Wall<2>& other) {
    return &other != &wall && other.present && other.shape == Wall<2>::Shape::kHalfPlane &&
           (x - other.a).dot(other.normal) < 0;
  });
}

}  // namespace

Box<2> view_box(std::span<const Disk> disks, std::span<const Wall<2>> walls) {
  Box<2> box;
  double largest = 0;
  for (const Disk& d : disks) {
    box.include(d.x, d.radius);
    largest = std::max(largest, d.radius);
  }
  if (box.empty()) {
    for (const Wall<2>& w : walls) {
      box.include(w.a);
      if (w.is_circle()) box.include(w.a, w.radius);
      if (w.shape == Wall<2>::Shape::kSegment) box.include(w.b);
    }
    if (box.empty()) box.include(Vec2::Zero());
    const double width = box.size().maxCoeff();
    box.widen(width > 0 ? 0.1 * width : 1.0);
    return box;
  }
  const Box<2> of_disks = box;
  const double reach = std::max(of_disks.size().maxCoeff(), 12 * largest);
  for (const Wall<2>& w : walls) {
    if (!w.present) continue;
    // A circle that contains the disks, or lies among them, is shown whole.
    if (w.is_circle() &&
        (nearest_point(w, of_disks.centre()) - of_disks.centre()).norm() <= reach) {
      box.include(w.a, w.radius);
    }
    for (const Vec2& x :
         {of_disks.centre(), of_disks.lower, of_disks.upper,
          Vec2(of_disks.lower[0], of_disks.upper[1]), Vec2(of_disks.upper[0], of_disks.lower[1])}) {
      const Vec2 near = nearest_point(w, x);
      const Vec2 inside = of_disks.nearest(near);
      if ((near - inside).norm() <= reach && !is_hidden(near, w, walls)) box.include(near);
    }
  }
  box.widen(std::max(0.03 * box.size().maxCoeff(), 0.5 * largest));
  return box;
}

std::vector<std::pair<Vec2, Vec2>> wall_lines(std::span<const Wall<2>> walls, const Box<2>& box) {
  std::vector<std::pair<Vec2, Vec2>> lines;
  for (const Wall<2>& wall : walls) {
    if (wall.is_circle() || !wall.present) {
      lines.emplace_back(wall.a, wall.a);
      continue;
    }
    if (wall.shape == Wall<2>::Shape::kSegment) {
      lines.emplace_back(wall.a, wall.b);
      continue;
    }
    const Vec2 t(-wall.normal[1], wall.normal[0]);
    double first = 1e300, last = -1e300;
    for (const Vec2& corner : {box.lower, box.upper, Vec2(box.lower[0], box.upper[1]),
                               Vec2(box.upper[0], box.lower[1])}) {
      first = std::min(first, (corner - wall.a).dot(t));
      last = std::max(last, (corner - wall.a).dot(t));
    }
    double seen_first = first, seen_last = last;
    for (const Wall<2>& other : walls) {
      if (&other == &wall || other.shape != Wall<2>::Shape::kHalfPlane || !other.present) continue;
      // Height above the other one at the parameter x: height + slope x.
      const double height = (wall.a - other.a).dot(other.normal);
      const double slope = t.dot(other.normal);
      if (slope > 1e-9) seen_first = std::max(seen_first, -height / slope);
      if (slope < -1e-9) seen_last = std::min(seen_last, -height / slope);
    }
    if (seen_first < seen_last) {  // otherwise it is hidden entirely, and is then shown whole
      first = seen_first;
      last = seen_last;
    }
    lines.emplace_back(wall.a + first * t, wall.a + last * t);
  }
  return lines;
}

}  // namespace bipot
