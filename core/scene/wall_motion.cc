#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

template <int D>
bool turns(const WallIn<D>& wall) {
  return wall.is_circle() && wall.spin != 0;
}

/// A circle's surface against its centre: spin e3 x r, r from the centre to the contact, which lies
/// along n on a solid circle and against it in a hollow one.
Vec2 turning(const Wall& wall, const Vec2& n) {
  const bool solid = wall.shape == Wall::Shape::kSolidCircle;
  const double rim = wall.spin * (solid ? wall.radius : -wall.radius);
  return Vec2(-rim * n[1], rim * n[0]);
}
/// The same of a cylinder about its axis.
Vec3 turning(const WallIn<3>& wall, const Vec3& n) {
  const bool solid = wall.shape == WallIn<3>::Shape::kSolidCircle;
  return wall.spin * (solid ? wall.radius : -wall.radius) * wall.normal.cross(n);
}

}  // namespace

template <int D>
std::vector<WallIn<D>> walls_at(const std::vector<WallIn<D>>& scene_walls,
                                const std::vector<WallIn<D>>& now, double time) {
  using Motion = typename WallIn<D>::Motion;
  std::vector<WallIn<D>> walls = now;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    const WallIn<D>& definition = scene_walls[w];
    if (!has_schedule(definition)) continue;
    WallIn<D>& wall = walls[w];
    wall.present = time < definition.removed;
    const bool moves = time >= definition.starts && time < definition.stops && wall.present;
    wall.motion = moves ? definition.motion : Motion::kFixed;
    wall.spin = moves ? definition.spin : 0;
    if (!moves) {
      wall.v.setZero();
    } else if (definition.motion == Motion::kMoving) {
      wall.v = definition.v;
    } else if (definition.motion == Motion::kDriven && now[w].motion != definition.motion) {
      wall.v = definition.v;  // it starts with the speed that the scene gives it
    }
  }
  return walls;
}

template <int D>
VecIn<D> driven_velocity(const WallIn<D>& wall, double speed) {
  VecIn<D> v = speed * wall.direction;
  if (!wall.across.isZero(0)) v += wall.across;
  return v;
}

template <int D>
double driven_speed(const WallIn<D>& wall) {
  return (wall.v - wall.across).dot(wall.direction);
}

template <int D>
double wall_kinetic_energy(const WallIn<D>& wall) {
  if (wall.motion != WallIn<D>::Motion::kDriven) return 0;
  return 0.5 * wall.mass * (wall.v - wall.across).squaredNorm();
}

template <int D>
VecIn<D> wall_momentum(const WallIn<D>& wall) {
  if (wall.motion != WallIn<D>::Motion::kDriven) return VecIn<D>::Zero();
  return wall.mass * (wall.v - wall.across);
}

template <int D>
VecIn<D> surface_velocity(const WallIn<D>& wall, const std::type_identity_t<VecIn<D>>& v,
                          const std::type_identity_t<VecIn<D>>& n) {
  return turns(wall) ? VecIn<D>(v + turning(wall, n)) : v;
}

template <int D>
VecIn<D> prescribed_velocity(const WallIn<D>& wall, const std::type_identity_t<VecIn<D>>& n) {
  return surface_velocity(wall, wall.motion == WallIn<D>::Motion::kDriven ? wall.across : wall.v,
                          n);
}

template std::vector<Wall> walls_at(const std::vector<Wall>&, const std::vector<Wall>&, double);
template Vec2 driven_velocity(const Wall&, double);
template double driven_speed(const Wall&);
template double wall_kinetic_energy(const Wall&);
template Vec2 wall_momentum(const Wall&);
template Vec2 surface_velocity<2>(const Wall&, const Vec2&, const Vec2&);
template Vec2 prescribed_velocity<2>(const Wall&, const Vec2&);
template std::vector<WallIn<3>> walls_at(const std::vector<WallIn<3>>&,
                                         const std::vector<WallIn<3>>&, double);
template Vec3 driven_velocity(const WallIn<3>&, double);
template double driven_speed(const WallIn<3>&);
template double wall_kinetic_energy(const WallIn<3>&);
template Vec3 wall_momentum(const WallIn<3>&);
template Vec3 surface_velocity<3>(const WallIn<3>&, const Vec3&, const Vec3&);
template Vec3 prescribed_velocity<3>(const WallIn<3>&, const Vec3&);

}  // namespace bipot
