#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

/// Velocity of the surface of a circle or cylinder relative to its centre or axis: spin times r, a
/// quarter turn on, with r to the contact. It lies along n on a solid circle and against n on a
/// hollow one.
template <int D>
Vec<D> rim_velocity(const Wall<D>& wall, const Vec<D>& n) {
  const bool solid = wall.shape == Wall<D>::Shape::kSolidCircle;
  const double rim = wall.spin * (solid ? wall.radius : -wall.radius);
  if constexpr (D == 2) {
    return swept(rim, n);
  } else {
    return rim * wall.normal.cross(n);
  }
}

}  // namespace

template <int D>
std::vector<Wall<D>> walls_at(const std::vector<Wall<D>>& scene_walls,
                              const std::vector<Wall<D>>& now, double time, double span) {
  using Motion = typename Wall<D>::Motion;
  std::vector<Wall<D>> walls = now;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    const Wall<D>& definition = scene_walls[w];
    if (!has_schedule(definition)) continue;
    Wall<D>& wall = walls[w];
    wall.present = time < definition.removed;
    const bool moves = time >= definition.starts && time < definition.stops && wall.present;
    wall.motion = moves ? definition.motion : Motion::kFixed;
    const double factor = definition.time_factor.mean(time - 0.5 * span, time + 0.5 * span);
    wall.spin = moves ? factor * definition.spin : 0;
    wall.belt = moves ? Vec<D>(factor * definition.belt) : Vec<D>(Vec<D>::Zero());
    wall.force = factor * definition.force;
    wall.factor_rate =
        moves && definition.motion != Motion::kDriven ? definition.time_factor.rate(time) : 0;
    if (!moves) {
      wall.v.setZero();
    } else if (definition.motion == Motion::kMoving) {
      wall.v = factor * definition.v;
    } else if (definition.motion == Motion::kDriven && now[w].motion != definition.motion) {
      wall.v = definition.v;  // it starts with the speed that the scene gives it
    }
  }
  return walls;
}

template <int D>
Vec<D> surface_velocity(const Wall<D>& wall, const std::type_identity_t<Vec<D>>& v,
                        const std::type_identity_t<Vec<D>>& n) {
  if (wall.is_circle()) return wall.spin != 0 ? Vec<D>(v + rim_velocity<D>(wall, n)) : v;
  if (wall.belt.isZero(0)) return v;
  const Vec<D> running = wall.belt - wall.belt.dot(n) * n;  // turns with n at the ends of a segment
  return v + running;
}

template std::vector<Wall<2>> walls_at(const std::vector<Wall<2>>&, const std::vector<Wall<2>>&,
                                       double, double);
template Vec2 surface_velocity<2>(const Wall<2>&, const Vec2&, const Vec2&);
template std::vector<Wall<3>> walls_at(const std::vector<Wall<3>>&, const std::vector<Wall<3>>&,
                                       double, double);
template Vec3 surface_velocity<3>(const Wall<3>&, const Vec3&, const Vec3&);

}  // namespace bipot
