#include "core/scene/wall_motion.h"

#include <algorithm>

namespace bipot {
namespace {

/// Velocity of a belt's surface at a contact: at the ends of a segment it turns with the normal.
template <int D>
Vec<D> running(const Wall<D>& wall, const Vec<D>& n) {
  return wall.belt - wall.belt.dot(n) * n;
}

/// Velocity of a circle's surface relative to its centre: spin e3 x r, with r from the centre to
/// the contact. It lies along n on a solid circle and against n on a hollow one.
Vec2 turning(const Wall<2>& wall, const Vec2& n) {
  const bool solid = wall.shape == Wall<2>::Shape::kSolidCircle;
  const double rim = wall.spin * (solid ? wall.radius : -wall.radius);
  return Vec2(-rim * n[1], rim * n[0]);
}
/// The same for a cylinder about its axis.
Vec3 turning(const Wall<3>& wall, const Vec3& n) {
  const bool solid = wall.shape == Wall<3>::Shape::kSolidCircle;
  return wall.spin * (solid ? wall.radius : -wall.radius) * wall.normal.cross(n);
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
    wall.factor_rate = wall.motion == Motion::kMoving ? definition.time_factor.rate(time) : 0;
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
  if (wall.is_circle()) return wall.spin != 0 ? Vec<D>(v + turning(wall, n)) : v;
  return wall.belt.isZero(0) ? v : Vec<D>(v + running<D>(wall, n));
}

template std::vector<Wall<2>> walls_at(const std::vector<Wall<2>>&, const std::vector<Wall<2>>&,
                                       double, double);
template Vec2 surface_velocity<2>(const Wall<2>&, const Vec2&, const Vec2&);
template std::vector<Wall<3>> walls_at(const std::vector<Wall<3>>&, const std::vector<Wall<3>>&,
                                       double, double);
template Vec3 surface_velocity<3>(const Wall<3>&, const Vec3&, const Vec3&);

}  // namespace bipot
