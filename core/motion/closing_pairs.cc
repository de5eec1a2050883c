#include "core/motion/closing_pairs.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/motion/body_forces.h"
#include "core/scene/periodic_detection.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

/// In larger scenes no body is followed farther than this multiple of the smallest radius.
constexpr std::size_t kFewBodies = 64;
constexpr double kLongestWay = 2;

template <int D>
PairPlace<D> between(const Vec<D>& from, double distance, double radii) {
  if (distance == 0) return {-radii, Vec<D>::Zero(), 0};
  return {distance - radii, from / distance, 1 / distance};
}

template <int D>
PairPlace<D> at_wall(const Vec<D>& x, double radius, const Wall<D>& wall) {
  if (!wall.present) return {};
  if (wall.shape == Wall<D>::Shape::kHalfPlane) {
    return {wall.normal.dot(x - wall.a) - radius, wall.normal, 0};
  }
  if (wall.shape == Wall<D>::Shape::kSegment) {
    const Vec<D> along = wall.b - wall.a;
    const double t = (x - wall.a).dot(along) / along.squaredNorm();
    const Vec<D> from = x - (wall.a + std::clamp(t, 0.0, 1.0) * along);
    PairPlace<D> place = between<D>(from, from.norm(), radius);
    if (t > 0 && t < 1) place.bend = 0;
    return place;
  }
  Vec<D> from = x - wall.a;
  if constexpr (D == 3) from -= from.dot(wall.normal) * wall.normal;
  const double distance = from.norm();
  PairPlace<D> place = between<D>(from, distance, wall.radius + radius);
  if (wall.shape == Wall<D>::Shape::kSolidCircle) return place;
  return {wall.radius - radius - distance, -place.n, -place.bend};
}

/// The velocity without its part along the axis of a cylinder, which changes no gap.
template <int D>
Vec<D> across_axis(const Vec<D>& v, const Wall<D>& wall) {
  if constexpr (D == 3) {
    if (wall.is_circle()) return v - v.dot(wall.normal) * wall.normal;
  }
  return v;
}

/// The way of a body in h.
double way(double speed, double acceleration, double h) {
  return h * speed + 0.5 * h * h * acceleration;
}

/// The time for a way; infinite if nothing moves.
double time_for(double way, double speed, double acceleration) {
  const double root = speed + std::sqrt(speed * speed + 2 * acceleration * way);
  return root > 0 ? 2 * way / root : kInfinity;
}

/// When and how a pair closes that moves with v and a, one against the other; never: infinite time.
template <int D>
Closing<D> closing(int i, int j, const PairPlace<D>& place, const Vec<D>& v, const Vec<D>& a,
                   double touch) {
  const double u_n = v.dot(place.n);
  const double c = a.dot(place.n) + (v.squaredNorm() - u_n * u_n) * place.bend;
  if (place.gap <= touch) return {i, j, u_n < 0 ? 0 : kInfinity, -u_n, c};
  const double root2 = u_n * u_n - 2 * c * place.gap;
  if (!(root2 > 0)) return {i, j, kInfinity, 0, c};
  const double root = std::sqrt(root2);
  const double time = 2 * place.gap / (root - u_n);
  return {i, j, time > 0 ? time : kInfinity, root, c};
}

template <int D>
Vec2 image_acceleration(const Accelerations<D>& a, int kx, int ky) {
  return Vec2(kx * a.sides[0] + ky * a.sides[2], ky * a.sides[1]);
}

/// What moves along with a body of that cell.
template <int D>
Vec<D> own_velocity(const Body<D>& body, const PeriodicCell& cell, const Vec<D>& common) {
  return cell.deforms() ? body.v - image_velocity(cell, body.x) : body.v - common;
}

}  // namespace

template <int D>
Accelerations<D> free_accelerations(const Scene<D>& scene, const State<D>& state,
                                    const std::vector<Wall<D>>& walls) {
  Accelerations<D> a;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    const Wall<D>& wall = walls[w];
    a.walls.push_back(wall.motion == Wall<D>::Motion::kDriven
                          ? Vec<D>(wall.force / wall.mass * wall.direction)
                          : Vec<D>(wall.factor_rate * scene.walls[w].v));
  }
  a.bodies.assign(state.bodies.size(), gravity_at(scene, state.time));
  if (has_body_forces(scene)) {
    add_force_accelerations<D>(scene, state.cell, state.time, state.bodies, a.bodies);
  }
  for (std::size_t k = 0; k < state.bodies.size(); ++k) {
    const int wall = state.bodies[k].wall;
    if (wall >= 0) a.bodies[k] = a.walls[to_size(wall)];
  }
  a.spins.assign(state.bodies.size(), no_turn<D>());
  for (int k = 0; k < 3; ++k) {
    const CellSide& side = state.cell.side(k);
    if (side.motion != CellSide::Motion::kDriven) continue;
    a.sides[k] = stress_force(state.cell, k) / side.mass;
  }
  const PeriodicCell& cell = state.cell;  // the derivative of offset_rate()
  if (cell.width.motion == CellSide::Motion::kDriven) {
    a.sides[2] += (cell.offset.length * a.sides[0] + cell.offset.speed * cell.width.speed) /
                  cell.width.length;
  }
  return a;
}

template <int D>
Accelerations<D> mean_accelerations(const Scene<D>& scene, const State<D>& before,
                                    const State<D>& after, double h) {
  Accelerations<D> a;
  a.bodies.reserve(after.bodies.size());
  a.spins.reserve(after.bodies.size());
  for (std::size_t k = 0; k < after.bodies.size(); ++k) {
    a.bodies.push_back((after.bodies[k].v - before.bodies[k].v) / h);
    a.spins.push_back((after.bodies[k].spin - before.bodies[k].spin) / h);
  }
  for (std::size_t w = 0; w < after.walls.size(); ++w) {
    const Wall<D>& wall = after.walls[w];
    a.walls.push_back(wall.factor_rate != 0 ? Vec<D>(wall.factor_rate * scene.walls[w].v)
                                            : Vec<D>((wall.v - before.walls[w].v) / h));
  }
  for (std::size_t k = 0; k < after.bodies.size(); ++k) {
    if (after.bodies[k].wall >= 0) a.bodies[k] = a.walls[to_size(after.bodies[k].wall)];
  }
  for (int k = 0; k < 3; ++k) {
    a.sides[k] = (after.cell.side(k).speed - before.cell.side(k).speed) / h;
  }
  a.sides[2] = (after.cell.offset_rate() - before.cell.offset_rate()) / h;
  return a;
}

template <int D>
PairPlace<D> pair_place(const std::vector<Body<D>>& bodies, const std::vector<Wall<D>>& walls,
                        const PeriodicCell& cell, const typename NearPairs<D>::Pair& pair) {
  const Body<D>& body = bodies[to_size(pair.i)];
  const std::size_t j = to_size(pair.j);
  Vec<D> x = body.x;
  if (pair.image_x != 0 || pair.image_y != 0) {
    x -= in_dimensions<D>(cell.shift(pair.image_x, pair.image_y));
  }
  if (j >= bodies.size()) return at_wall<D>(x, body.radius, walls[j - bodies.size()]);
  const Vec<D> from = x - bodies[j].x;
  return between<D>(from, from.norm(), body.radius + bodies[j].radius);
}

template <int D>
ClosingPairs<D>::ClosingPairs(const Scene<D>& scene, int threads)
    : scene_(scene), threads_(threads) {
  if (!scene.cell.periodic()) return;
  std::vector<std::vector<const Body<D>*>> members(scene.clusters.bodies.size());
  for (const Body<D>& d : scene.bodies) {
    longest_body_ = std::max(longest_body_, 4 * d.radius);
    if (d.cluster < 0) continue;
    for (const Body<D>* other : members[to_size(d.cluster)]) {
      longest_body_ = std::max(longest_body_, (d.x - other->x).norm() + d.radius + other->radius);
    }
    members[to_size(d.cluster)].push_back(&d);
  }
}

/// Calls visit(pair) for bodies and walls, with the images of visit_wall_images().
template <int D>
template <class Visit>
void ClosingPairs<D>::visit_walls(const State<D>& state, const std::vector<Wall<D>>& walls,
                                  const Visit& visit) {
  const int count = static_cast<int>(state.bodies.size());
  for (int i = 0; i < count; ++i) {
    const Body<D>& body = state.bodies[to_size(i)];
    if (body.wall >= 0) continue;
    for (std::size_t w = 0; w < walls.size(); ++w) {
      const Wall<D>& wall = walls[w];
      if (!wall.present) continue;
      const int j = count + static_cast<int>(w);
      visit_wall_images<D>(state.cell, wall, body.x, [&](int kx, int ky) {
        visit({i, j, kx, ky});
      });
    }
  }
}

template <int D>
std::vector<Closing<D>> ClosingPairs<D>::find(const State<D>& state,
                                              const std::vector<Wall<D>>& walls,
                                              const Accelerations<D>& a, double& h) {
  const std::vector<Body<D>>& bodies = state.bodies;
  const PeriodicCell& cell = state.cell;
  Vec<D> common = Vec<D>::Zero(), common_a = Vec<D>::Zero();
  double smallest = kInfinity;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    common += bodies[k].v;
    common_a += a.bodies[k];
    smallest = std::min(smallest, bodies[k].radius);
  }
  if (!bodies.empty() && !cell.periodic()) {
    common /= static_cast<double>(bodies.size());
    common_a /= static_cast<double>(bodies.size());
  } else {
    common = common_a = Vec<D>::Zero();
  }
  // How far everything can get; as far as there is room to look.
  double longest = NearPairs<D>::longest_way(cell, longest_body_);
  if (bodies.size() > kFewBodies) longest = std::min(longest, kLongestWay * smallest);
  const int widths = NearPairs<D>::most_widths(cell);
  const double image_speed =
      cell.deforms() ? widths * cell.shift_velocity(1, 0).norm() + cell.shift_velocity(0, 1).norm()
                     : 0;
  const double image_a =
      widths * image_acceleration(a, 1, 0).norm() + image_acceleration(a, 0, 1).norm();
  if (std::isfinite(longest)) {
    h = std::min(h, time_for(longest, image_speed, image_a));
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      h = std::min(h, time_for(longest, own_velocity<D>(bodies[k], cell, common).norm(),
                               (a.bodies[k] - common_a).norm()));
    }
  }
  ways_.resize(bodies.size());
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    ways_[k] =
        way(own_velocity<D>(bodies[k], cell, common).norm(), (a.bodies[k] - common_a).norm(), h);
  }
  const double image_way = way(image_speed, image_a, h);

  std::vector<Closing<D>> found;
  const double touch = scene_.contact_distance;
  const auto add = [&](const Closing<D>& c) {
    if (c.time < h) found.push_back(c);
  };
  for (const auto& pair : near_.within(bodies, cell, ways_, image_way, threads_)) {
    const std::size_t i = to_size(pair.i), j = to_size(pair.j);
    const Body<D>&one = bodies[i], &other = bodies[j];
    const bool image = pair.image_x != 0 || pair.image_y != 0;
    Vec<D> from = one.x - other.x, v = one.v - other.v, da = a.bodies[i] - a.bodies[j];
    if (image) {
      from -= in_dimensions<D>(cell.shift(pair.image_x, pair.image_y));
      v -= in_dimensions<D>(cell.shift_velocity(pair.image_x, pair.image_y));
      da -= in_dimensions<D>(image_acceleration(a, pair.image_x, pair.image_y));
    }
    const double radii = one.radius + other.radius;
    const double reach = radii + ways_[i] + ways_[j] + image_way;
    const double distance2 = from.squaredNorm();
    if (distance2 > reach * reach) continue;
    const PairPlace<D> place = between<D>(from, std::sqrt(distance2), radii);
    add(closing<D>(pair.i, pair.j, place, v, da, touch));
  }
  const auto count = bodies.size();
  std::vector<double> wall_ways;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    wall_ways.push_back(way((walls[w].v - common).norm(), (a.walls[w] - common_a).norm(), h));
  }
  visit_walls(state, walls, [&](const typename NearPairs<D>::Pair& pair) {
    const std::size_t i = to_size(pair.i), w = to_size(pair.j) - count;
    const PairPlace<D> place = pair_place<D>(bodies, walls, cell, pair);
    if (place.gap > ways_[i] + wall_ways[w]) return;
    const Vec<D> v = across_axis<D>(bodies[i].v - walls[w].v, walls[w]);
    add(closing<D>(pair.i, pair.j, place, v, a.bodies[i] - a.walls[w], touch));
  });
  std::sort(found.begin(), found.end(), [](const Closing<D>& x, const Closing<D>& y) {
    return std::tie(x.time, x.i, x.j) < std::tie(y.time, y.i, y.j);
  });
  return found;
}

template <int D>
std::vector<typename NearPairs<D>::Pair> ClosingPairs<D>::overlapping(const State<D>& state) {
  std::vector<typename NearPairs<D>::Pair> found;
  const std::vector<Body<D>>& bodies = state.bodies;
  ways_.assign(bodies.size(), 0.0);
  for (const auto& pair : near_.within(bodies, state.cell, ways_, 0, threads_)) {
    const Body<D>&one = bodies[to_size(pair.i)], &other = bodies[to_size(pair.j)];
    Vec<D> from = one.x - other.x;
    if (pair.image_x != 0 || pair.image_y != 0) {
      from -= in_dimensions<D>(state.cell.shift(pair.image_x, pair.image_y));
    }
    const double radii = one.radius + other.radius;
    if (from.squaredNorm() < radii * radii) found.push_back(pair);
  }
  visit_walls(state, state.walls, [&](const typename NearPairs<D>::Pair& pair) {
    if (pair_place<D>(bodies, state.walls, state.cell, pair).gap < 0) found.push_back(pair);
  });
  return found;
}

template Accelerations<2> free_accelerations(const Scene<2>&, const State<2>&,
                                             const std::vector<Wall<2>>&);
template Accelerations<3> free_accelerations(const Scene<3>&, const State<3>&,
                                             const std::vector<Wall<3>>&);
template Accelerations<2> mean_accelerations(const Scene<2>&, const State<2>&, const State<2>&,
                                             double);
template Accelerations<3> mean_accelerations(const Scene<3>&, const State<3>&, const State<3>&,
                                             double);
template PairPlace<2> pair_place(const std::vector<Disk>&, const std::vector<Wall<2>>&,
                                 const PeriodicCell&, const NearPairs<2>::Pair&);
template PairPlace<3> pair_place(const std::vector<Sphere>&, const std::vector<Wall<3>>&,
                                 const PeriodicCell&, const NearPairs<3>::Pair&);
template class ClosingPairs<2>;
template class ClosingPairs<3>;

}  // namespace bipot
