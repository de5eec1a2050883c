#include "core/motion/sample_area.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace bipot {
namespace {

constexpr int kRimPoints = 256;

double cross(const Vec2& a, const Vec2& b) { return a[0] * b[1] - a[1] * b[0]; }

double polygon_area(const std::vector<Vec2>& corners) {
  double twice = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    twice += cross(corners[k] - corners[0], corners[(k + 1) % corners.size()] - corners[0]);
  }
  return 0.5 * twice;
}

/// The part of a convex polygon in front of the half-plane.
std::vector<Vec2> clip(const std::vector<Vec2>& polygon, const Vec2& point, const Vec2& normal) {
  std::vector<Vec2> kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec2 &p = polygon[k], &q = polygon[(k + 1) % polygon.size()];
    const double at_p = (p - point).dot(normal), at_q = (q - point).dot(normal);
    if (at_p >= 0) kept.push_back(p);
    if ((at_p > 0 && at_q < 0) || (at_p < 0 && at_q > 0)) {
      kept.emplace_back(p + at_p / (at_p - at_q) * (q - p));
    }
  }
  return kept;
}

/// Area of a periodic cell at mid-step. If it is not periodic in y, it is as high as the
/// half-planes allow, or the disks reach.
double cell_area(const State<2>& state, double step, const Box<2>& disks) {
  PeriodicCell cell = state.cell;
  move_cell(cell, -0.5 * step);
  if (cell.in_y) return cell.width.length * cell.height.length;
  double low = -kInfinity, high = kInfinity;
  for (const Wall<2>& w : state.walls) {
    if (w.shape != Wall<2>::Shape::kHalfPlane || !w.present) continue;
    const double at = w.a[1] - 0.5 * step * w.v[1];
    if (w.normal[1] > 0) low = std::max(low, at);
    if (w.normal[1] < 0) high = std::min(high, at);
  }
  if (!std::isfinite(low)) low = disks.lower[1];
  if (!std::isfinite(high)) high = disks.upper[1];
  return cell.width.length * (high - low);
}

/// Area of the smallest hollow circle that holds all disks, less that of solid circles in it; NaN
/// without one. Half-planes have no effect.
double drum_area(const State<2>& state, double step) {
  double smallest = kInfinity;
  Vec2 centre = Vec2::Zero();
  for (const Wall<2>& w : state.walls) {
    if (w.shape != Wall<2>::Shape::kHollowCircle || !w.present || !(w.radius < smallest)) continue;
    const Vec2 at = w.a - 0.5 * step * w.v;
    const bool holds = std::all_of(state.bodies.begin(), state.bodies.end(), [&](const Disk& d) {
      return (middle_of_step(d, step) - at).norm() < w.radius;
    });
    if (!holds) continue;
    smallest = w.radius;
    centre = at;
  }
  double area = std::numbers::pi * smallest * smallest;
  for (const Wall<2>& w : state.walls) {
    const bool half_plane = w.shape == Wall<2>::Shape::kHalfPlane && w.present;
    if (half_plane) return kNaN;
    if (w.shape != Wall<2>::Shape::kSolidCircle || !w.present) continue;
    const double reach = (w.a - 0.5 * step * w.v - centre).norm() + w.radius;
    if (reach <= smallest) area -= std::numbers::pi * w.radius * w.radius;
  }
  return area;
}

/// Area enclosed by the half-planes; NaN if they leave the sample open, or do not contain all
/// disks.
double enclosed_area(const State<2>& state, double step, const Box<2>& disks) {
  constexpr double kFar = 1e3;  // an enclosure this many times as wide as the disks counts as none
  Box<2> far = disks;
  far.widen(kFar * disks.size().maxCoeff());
  std::vector<Vec2> polygon = {far.lower, Vec2(far.upper[0], far.lower[1]), far.upper,
                               Vec2(far.lower[0], far.upper[1])};
  for (const Wall<2>& w : state.walls) {
    if (w.shape != Wall<2>::Shape::kHalfPlane || !w.present) continue;
    const Vec2 point = w.a - 0.5 * step * w.v;
    for (const Disk& d : state.bodies) {
      if ((middle_of_step(d, step) - point).dot(w.normal) < 0) return kNaN;
    }
    polygon = clip(polygon, point, w.normal);
  }
  for (const Vec2& corner : polygon) {
    const Vec2 room = (corner - far.lower).cwiseMin(far.upper - corner);
    if (room.minCoeff() <= disks.size().maxCoeff()) return kNaN;
  }
  return polygon.size() < 3 ? kNaN : polygon_area(polygon);
}

/// A polygon of sixteen points of the hull, which are among its rim points. Only places outside of
/// it, to rounding, may lie on the edge of the hull.
class InnerPolygon {
 public:
  InnerPolygon(const std::vector<Vec2>& centres, const std::vector<double>& radii,
               const std::vector<Vec2>& directions, const Box<2>& box)
      : margin_(1e-9 * box.size().maxCoeff()) {
    constexpr std::size_t kStride = kRimPoints / 16;
    std::vector<Vec2> corners;  // anticlockwise
    for (std::size_t at = 0; at < directions.size(); at += kStride) {
      std::size_t farthest = 0;
      double reach = -kInfinity;
      for (std::size_t k = 0; k < centres.size(); ++k) {
        const double here = centres[k].dot(directions[at]) + radii[k];
        if (here > reach) {
          reach = here;
          farthest = k;
        }
      }
      corners.emplace_back(centres[farthest] + radii[farthest] * directions[at]);
    }
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vec2 along = corners[(k + 1) % corners.size()] - corners[k];
      const double length = along.norm();
      if (length > 0) sides_.push_back({corners[k], Vec2(-along[1], along[0]) / length});
    }
  }
  /// True if a circle lies within it.
  bool contains(const Vec2& centre, double radius) const {
    return sides_.size() >= 3 && std::all_of(sides_.begin(), sides_.end(), [&](const Side& s) {
             return (centre - s.from).dot(s.inward) > radius + margin_;
           });
  }

 private:
  struct Side {
    Vec2 from, inward;
  };
  double margin_;
  std::vector<Side> sides_;
};

/// Marks the disks that extend farthest in some direction: all that have a part of the hull.
class OuterDisks {
 public:
  /// Keeps references to all. `among`: the disks that may be outer ones.
  OuterDisks(const std::vector<Vec2>& centres, const std::vector<double>& radii,
             const std::vector<std::size_t>& among, double margin)
      : among_(among), margin_(margin), centres_(centres), radii_(radii) {
    outer_.resize(radii_.size());
    const Vec2 axes[] = {Vec2::UnitX(), Vec2::UnitY(), -Vec2::UnitX(), -Vec2::UnitY()};
    std::array<std::size_t, 4> far{};
    for (std::size_t k = 0; k < 4; ++k) far[k] = farthest(axes[k]);
    for (std::size_t k = 0; k < 4; ++k) {
      between(axes[k], far[k], axes[(k + 1) % 4], far[(k + 1) % 4]);
    }
  }
  bool contain(std::size_t disk) const { return outer_[disk]; }

 private:
  double reach(std::size_t k, const Vec2& u) const { return centres_[k].dot(u) + radii_[k]; }
  std::size_t farthest(const Vec2& u) const {
    return *std::max_element(among_.begin(), among_.end(), [&](std::size_t k, std::size_t l) {
      return reach(k, u) < reach(l, u);
    });
  }

  /// The direction in the arc in which one disk extends farthest beyond disk a: 0 if none does.
  Vec2 beyond(std::size_t a, const Vec2& from, const Vec2& to) const {
    double most = margin_;
    Vec2 best = Vec2::Zero();
    for (const std::size_t k : among_) {
      const Vec2 d = centres_[k] - centres_[a];
      const double length = d.norm();
      if (length + radii_[k] - radii_[a] <= most) continue;
      if (!(cross(from, d) > 0 && cross(d, to) > 0)) continue;
      most = length + radii_[k] - radii_[a];
      best = d / length;
    }
    return best;
  }

  /// Finds the outer disks between two directions, where a and b extend farthest. Other disks are
  /// sought where a and b extend equally far, on the outer side of their tangent.
  void between(const Vec2& from, std::size_t a, const Vec2& to, std::size_t b) {
    outer_[a] = outer_[b] = true;
    if (a == b) {
      const Vec2 u = beyond(a, from, to);
      if (u.isZero(0)) return;
      const std::size_t c = farthest(u);
      if (c == a) return;  // beyond by rounding alone
      between(from, a, u, c);
      between(u, c, to, a);
      return;
    }
    const Vec2 d = centres_[b] - centres_[a];
    const double length = d.norm(), along = (radii_[a] - radii_[b]) / length;
    if (!(std::abs(along) < 1)) return;  // one is in the other, to rounding
    const Vec2 u = (along * d + std::sqrt(1 - along * along) * Vec2(d[1], -d[0])) / length;
    // At an end of the arc both may extend equally far, to rounding: one has all of the arc.
    if (!(cross(from, u) > 0)) return between(from, b, to, b);
    if (!(cross(u, to) > 0)) return between(from, a, to, a);
    const std::size_t c = farthest(u);
    const bool none = reach(c, u) <= reach(a, u) + margin_;
    between(from, a, u, none ? a : c);
    between(u, none ? b : c, to, b);
  }

  const std::vector<std::size_t>& among_;
  double margin_;
  const std::vector<Vec2>& centres_;
  const std::vector<double>& radii_;
  std::vector<bool> outer_;
};

/// Andrew's monotone chain.
double hull_area(std::vector<Vec2> points) {
  const auto less = [](const Vec2& a, const Vec2& b) {
    return a[0] != b[0] ? a[0] < b[0] : a[1] < b[1];
  };
  std::sort(points.begin(), points.end(), less);
  std::vector<Vec2> hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t base = hull.size();
    for (const Vec2& p : points) {
      while (hull.size() >= base + 2 &&
             cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return polygon_area(hull);
}

}  // namespace

double sample_measure(const State<2>& state, double step) {
  if (state.bodies.empty()) return 0;
  Box<2> box;
  for (const Disk& d : state.bodies) box.include(middle_of_step(d, step), d.radius);
  if (state.cell.periodic()) return cell_area(state, step, box);
  if (const double enclosed = enclosed_area(state, step, box); std::isfinite(enclosed)) {
    return enclosed;
  }
  if (const double drum = drum_area(state, step); std::isfinite(drum)) return drum;
  std::vector<Vec2> directions;
  for (int k = 0; k < kRimPoints; ++k) {
    const double angle = 2 * std::numbers::pi * k / kRimPoints;
    directions.emplace_back(std::cos(angle), std::sin(angle));
  }
  std::vector<Vec2> centres;
  std::vector<double> radii;
  for (const Disk& d : state.bodies) {
    centres.push_back(middle_of_step(d, step));
    radii.push_back(d.radius);
  }
  const InnerPolygon inner(centres, radii, directions, box);
  std::vector<std::size_t> candidates;
  for (std::size_t k = 0; k < centres.size(); ++k) {
    if (!inner.contains(centres[k], radii[k])) candidates.push_back(k);
  }
  // Only disks that extend farthest in some direction have points on the hull.
  constexpr double kRounding = 1e-14;
  const OuterDisks outer(centres, radii, candidates, kRounding * box.size().maxCoeff());
  std::vector<Vec2> rim;
  for (const std::size_t k : candidates) {
    if (!outer.contain(k)) continue;
    for (const Vec2& direction : directions) {
      const Vec2 point = centres[k] + radii[k] * direction;
      if (!inner.contains(point, 0)) rim.push_back(point);
    }
  }
  return hull_area(std::move(rim));
}

}  // namespace bipot
