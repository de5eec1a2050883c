#include "core/motion/passage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/base/number_buffer.h"
#include "core/motion/population.h"
#include "core/scene/periodic_detection.h"
#include "core/scene/triangle_mesh.h"

namespace bipot {
namespace {

/// A pair with a smaller overlap than this part of the smaller radius grazes.
constexpr double kGrazing = 0.5;

/// A pair of which one goes through the other.
struct Pair {
  double touch = 0;  ///< distance of the centres in contact                             [m]
  double clear = 0;  ///< nearer, they do not only graze                                 [m]

  Pair(double radius, double other)
      : touch(radius + other), clear(touch - kGrazing * std::min(radius, other)) {}
};

/// Whether the pair, at p and then at q one against the other, came nearer than `clear` in between
/// and ends on the other side. Without contact at both ends any side will do: bodies that overlap
/// may be held by pins, and turn.
template <class V>
bool came_through(const V& p, const V& q, const Pair& pair) {
  const V d = q - p;
  const double t = -p.dot(d) / d.squaredNorm();  // where they are nearest; NaN without a way
  if (!(t > 0 && t < 1)) return false;
  const bool apart = p.norm() >= pair.touch && q.norm() >= pair.touch;
  return (apart || p.dot(q) < 0) && (p + t * d).norm() < pair.clear;
}

/// The same over a step from mid-step before to mid to the end. A step that began on the other body
/// is judged by the mid-steps around its begin.
template <class V>
bool passes(const V& before, const V& from, const V& mid, const V& to, const Pair& pair) {
  if (came_through(from, mid, pair) || came_through(mid, to, pair)) return true;
  return before.dot(from) >= 0 && from.norm() < pair.clear && came_through(before, mid, pair);
}

/// Whether the way from p to q crosses the segment from 0 to `along`, or ends on it.
bool crosses(const Vec2& p, const Vec2& q, const Vec2& along) {
  const auto cross = [](const Vec2& a, const Vec2& b) { return a[0] * b[1] - a[1] * b[0]; };
  const double before = cross(along, p), after = cross(along, q);
  if (before == 0 || before * after > 0) return false;
  const Vec2 at = p + before / (before - after) * (q - p);
  const double share = at.dot(along) / along.squaredNorm();
  return share >= 0 && share <= 1;
}

/// The same for a cone, whose point a is 0: |x - z axis| = r(z) is quadratic along the way.
bool crosses_cone(const Vec3& p, const Vec3& q, const Wall<3>& wall) {
  const double length = (wall.b - wall.a).norm();
  const Vec3 axis = (wall.b - wall.a) / length, way = q - p;
  const double z = p.dot(axis), dz = way.dot(axis), slope = (wall.radius_b - wall.radius) / length;
  const double r = wall.radius + slope * z, dr = slope * dz;
  const Vec3 at = p - z * axis, d = way - dz * axis;
  const double a = d.squaredNorm() - dr * dr, b = at.dot(d) - r * dr, c = at.squaredNorm() - r * r;
  const double root2 = b * b - a * c;
  if (root2 < 0 || (a == 0 && b == 0)) return false;
  const double sum = -(b + std::copysign(std::sqrt(root2), b));
  for (const double t : {a != 0 ? sum / a : kInfinity, sum != 0 ? c / sum : kInfinity}) {
    const double height = z + t * dz;
    if (t > 0 && t <= 1 && height >= 0 && height <= length) return true;
  }
  return false;
}

/// Whether a body at these places, against the wall, went through it.
template <int D>
bool through_wall(const Vec<D>& before, const Vec<D>& from, const Vec<D>& mid, const Vec<D>& to,
                  double radius, const Wall<D>& wall) {
  using Shape = typename Wall<D>::Shape;
  const auto across = [&](const Vec<D>& x) -> Vec<D> {  // from the axis of a cylinder
    if constexpr (D == 2) return x;
    return x - x.dot(wall.normal) * wall.normal;
  };
  const auto leaves = [&](const auto& height) {
    return (height(from) >= 0 && height(mid) < 0) || (height(mid) >= 0 && height(to) < 0);
  };
  switch (wall.shape) {
    case Shape::kHalfPlane:
      return leaves([&](const Vec<D>& x) { return x.dot(wall.normal); });
    case Shape::kHollowCircle:
      return leaves([&](const Vec<D>& x) { return wall.radius - across(x).norm(); });
    case Shape::kSolidCircle:
      return passes<Vec<D>>(across(before), across(from), across(mid), across(to),
                            Pair(radius, wall.radius));
    case Shape::kSegment:
      if constexpr (D == 2) {
        return crosses(from, mid, wall.b - wall.a) || crosses(mid, to, wall.b - wall.a);
      }
      break;
    case Shape::kMesh:
      if constexpr (D == 3) return wall.mesh->crossed(from, mid) || wall.mesh->crossed(mid, to);
      break;
    case Shape::kCone:
      if constexpr (D == 3) return crosses_cone(from, mid, wall) || crosses_cone(mid, to, wall);
  }
  return false;
}

/// Walls that a body can pass from both sides.
template <int D>
bool has_far_side(const Wall<D>& wall) {
  return wall.present && (wall.shape == Wall<D>::Shape::kSegment || wall.is_surface() ||
                          wall.shape == Wall<D>::Shape::kSolidCircle);
}

template <int D>
bool joined(const BodyPath<D>& a, const BodyPath<D>& b) {
  return (a.wall >= 0 && b.wall >= 0) || (a.cluster >= 0 && a.cluster == b.cluster);
}

/// One against the other, moved back to the nearest image in a periodic cell.
template <int D>
struct Against {
  Vec<D> earlier, from, mid, to;

  Against(const BodyPath<D>& a, const BodyPath<D>& b, const PeriodicCell& before,
          const PeriodicCell& after)
      : earlier(a.before - b.before), from(a.from - b.from), mid(a.mid - b.mid), to(a.to - b.to) {
    if (!after.periodic()) return;
    const auto [kx, ky] = nearest_corner(after, mid.template head<2>());
    const Vec<D> first = in_dimensions<D>(before.shift(kx, ky)),
                 last = in_dimensions<D>(after.shift(kx, ky));
    earlier -= first;
    from -= first;
    mid -= 0.5 * (first + last);
    to -= last;
  }
};

/// Passes what other processes need of a way.
template <class Path, class Pass>
void pass_path(Path& way, const Pass& pass) {
  pass(way.number, way.wall, way.cluster, way.radius, way.before, way.from, way.mid, way.to);
}

/// Calls visit(a, b) for pairs of which one is fast and one is here. Outside of cells only where
/// the ways overlap along the first axis.
template <int D, class F>
void for_near_pairs(const std::vector<BodyPath<D>>& ways, bool periodic, F&& visit) {
  const auto lower = [](const BodyPath<D>& w) {
    return std::min({w.from[0], w.mid[0], w.to[0]}) - w.radius;
  };
  const auto upper = [](const BodyPath<D>& w) {
    return std::max({w.from[0], w.mid[0], w.to[0]}) + w.radius;
  };
  std::vector<std::size_t> order(ways.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return lower(ways[a]) < lower(ways[b]); });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const BodyPath<D>& a = ways[order[k]];
    for (std::size_t l = k + 1; l < order.size(); ++l) {
      const BodyPath<D>& b = ways[order[l]];
      if (!periodic && lower(b) > upper(a)) break;
      if (!(a.fast || b.fast) || (a.elsewhere && b.elsewhere)) continue;
      // Two fast bodies of different processes are seen by both.
      const BodyPath<D>& first = a.number < b.number ? a : b;
      if (a.fast && b.fast && first.elsewhere) continue;
      visit(first, a.number < b.number ? b : a);
    }
  }
}

/// The square of the larger speed of a body at the two ends, against its cell.        [m²/s²]
template <int D>
double larger_speed2(const State<D>& before, const State<D>& after, std::size_t k) {
  const auto speed2 = [k](const State<D>& s) {
    return (s.bodies[k].v - image_velocity(s.cell, s.bodies[k].x)).squaredNorm();
  };
  return std::max(speed2(before), speed2(after));
}

/// How fast neighbouring cells move against each other at most.                        [m/s]
double jump_of(const PeriodicCell& cell) {
  const double aside = cell.in_y ? std::round(cell.offset.length / cell.width.length) : 0;
  return cell.shift_velocity(1, 0).norm() + cell.shift_velocity(-aside, 1).norm();
}

}  // namespace

template <int D>
StepTravel step_travel(const State<D>& before, const State<D>& after, double h) {
  StepTravel travel;
  double fastest = 0, relative = 0;  // squared
  for (std::size_t k = 0; k < after.bodies.size(); ++k) {
    const double speed2 = larger_speed2(before, after, k), radius = after.bodies[k].radius;
    fastest = std::max(fastest, speed2);
    relative = std::max(relative, speed2 / (radius * radius));
    travel.least = std::min(travel.least, radius);
  }
  travel.way = h * (std::sqrt(fastest) + jump_of(after.cell));
  travel.radii = h * std::sqrt(relative);
  for (const Wall<D>& wall : after.walls) {
    if (!has_far_side(wall)) continue;
    travel.wall_way = std::max(travel.wall_way, h * wall.v.norm());
    if (wall.is_circle()) travel.least = std::min(travel.least, wall.radius);
  }
  return travel;
}

template <int D>
std::vector<BodyPath<D>> paths_of(const State<D>& before, const State<D>& after, double h,
                                  const StepTravel& travel, const std::function<int(int)>& number) {
  std::vector<BodyPath<D>> ways(after.bodies.size());
  const double jump = jump_of(after.cell);
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const Body<D>&a = before.bodies[k], &b = after.bodies[k];
    ways[k] = {.number = number(static_cast<int>(k)),
               .before = middle_of_step(a, h),
               .from = a.x,
               .mid = middle_of_step(b, h),
               .to = b.x,
               .radius = b.radius,
               .wall = b.wall,
               .cluster = b.cluster,
               .fast = h * (std::sqrt(larger_speed2(before, after, k)) + jump) + travel.wall_way >
                       travel.least};
  }
  return ways;
}

template <int D>
std::vector<Passage> find_passages(const State<D>& before, const State<D>& after, double h,
                                   const std::vector<BodyPath<D>>& ways) {
  std::vector<Passage> passages;
  const auto speed = [&](const Vec<D>& from, const Vec<D>& mid, const Vec<D>& to) {
    return 2 * std::max((mid - from).norm(), (to - mid).norm()) / h;
  };
  for (const BodyPath<D>& way : ways) {
    if (!way.fast || way.elsewhere || way.wall >= 0) continue;
    for (std::size_t w = 0; w < after.walls.size(); ++w) {
      const Wall<D>& wall = after.walls[w];
      if (!wall.present) continue;
      const Wall<D>& then = before.walls[w];
      const Vec<D> earlier = way.before - (then.a - 0.5 * h * then.v), from = way.from - then.a,
                   mid = way.mid - (wall.a - 0.5 * h * wall.v), to = way.to - wall.a;
      bool through = false;
      visit_wall_images<D>(after.cell, wall, way.mid, [&](int kx, int ky) {
        const Vec<D> image = in_dimensions<D>(after.cell.shift(kx, ky));
        through = through || through_wall<D>(earlier - image, from - image, mid - image, to - image,
                                             way.radius, wall);
      });
      if (!through) continue;
      passages.push_back({way.number, -1, static_cast<int>(w), speed(from, mid, to)});
    }
  }
  for_near_pairs(ways, after.cell.periodic(), [&](const BodyPath<D>& a, const BodyPath<D>& b) {
    if (joined(a, b)) return;
    const Against<D> pair(a, b, before.cell, after.cell);
    const Pair size(a.radius, b.radius);
    if (!passes<Vec<D>>(pair.earlier, pair.from, pair.mid, pair.to, size)) return;
    passages.push_back({a.number, b.number, -1, speed(pair.from, pair.mid, pair.to)});
  });
  std::sort(passages.begin(), passages.end(), [](const Passage& a, const Passage& b) {
    return std::tie(a.i, a.j, a.wall) < std::tie(b.i, b.j, b.wall);
  });
  return passages;
}

template <int D>
std::vector<Passage> find_passages(const State<D>& before, const State<D>& after, double h) {
  const StepTravel travel = step_travel(before, after, h);
  if (!travel.may_pass()) return {};
  const auto number = [&](int k) { return body_number(before, k); };
  return find_passages(before, after, h, paths_of<D>(before, after, h, travel, number));
}

template <int D>
std::string passage_text(const Scene<D>& scene, const Passage& passage) {
  const std::string other = passage.wall >= 0
                                ? fmt::format("wall '{}'", scene.walls[to_size(passage.wall)].name)
                                : fmt::format("{} {}", kBodyName<D>, passage.j);
  return fmt::format("{} {} went through {} at {:.3g} m/s", kBodyName<D>, passage.i, other,
                     passage.speed);
}

template <int D>
std::vector<double> packed(const std::vector<BodyPath<D>>& ways) {
  Buffer numbers;
  for (const BodyPath<D>& way : ways) {
    pass_path(way, [&](const auto&... values) { append(numbers, values...); });
  }
  return numbers;
}

template <int D>
std::vector<BodyPath<D>> unpacked(const std::vector<double>& numbers) {
  std::vector<BodyPath<D>> ways;
  for (BufferReader reader(numbers); !reader.at_end();) {
    BodyPath<D>& way = ways.emplace_back();
    pass_path(way, [&](auto&... values) { reader.take(values...); });
    way.fast = way.elsewhere = true;
  }
  return ways;
}

template StepTravel step_travel(const State<2>&, const State<2>&, double);
template StepTravel step_travel(const State<3>&, const State<3>&, double);
template std::vector<BodyPath<2>> paths_of(const State<2>&, const State<2>&, double,
                                           const StepTravel&, const std::function<int(int)>&);
template std::vector<BodyPath<3>> paths_of(const State<3>&, const State<3>&, double,
                                           const StepTravel&, const std::function<int(int)>&);
template std::vector<Passage> find_passages(const State<2>&, const State<2>&, double,
                                            const std::vector<BodyPath<2>>&);
template std::vector<Passage> find_passages(const State<3>&, const State<3>&, double,
                                            const std::vector<BodyPath<3>>&);
template std::vector<Passage> find_passages(const State<2>&, const State<2>&, double);
template std::vector<Passage> find_passages(const State<3>&, const State<3>&, double);
template std::string passage_text(const Scene<2>&, const Passage&);
template std::string passage_text(const Scene<3>&, const Passage&);
template std::vector<double> packed(const std::vector<BodyPath<2>>&);
template std::vector<double> packed(const std::vector<BodyPath<3>>&);
template std::vector<BodyPath<2>> unpacked(const std::vector<double>&);
template std::vector<BodyPath<3>> unpacked(const std::vector<double>&);

}  // namespace bipot
