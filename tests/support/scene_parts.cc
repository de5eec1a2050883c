#include "tests/support/scene_parts.h"

namespace bipot {

Wall<2> half_plane(const Vec2& point, const Vec2& normal) {
  Wall<2> wall;
  wall.a = point;
  wall.normal = normal;
  return wall;
}

Disk cylinder(const Vec2& x, double radius, const Vec2& v, double mass, double spin) {
  Disk d;
  d.x = x;
  d.v = v;
  d.spin = spin;
  d.radius = radius;
  d.mass = mass;
  d.inertia = 0.5 * mass * radius * radius;
  return d;
}

Wall<3> half_space(const Vec3& point, const Vec3& normal) {
  Wall<3> wall;
  wall.a = point;
  wall.normal = normal;
  return wall;
}

Sphere ball(const Vec3& x, double radius, const Vec3& v, double mass, const Vec3& spin) {
  Sphere s;
  s.x = x;
  s.v = v;
  s.spin = spin;
  s.radius = radius;
  s.mass = mass;
  s.inertia = 0.4 * mass * radius * radius;
  return s;
}

Scene<3> one_law_in_space(const ContactLaw& law) {
  Scene<3> scene;
  scene.materials = {"m"};
  scene.laws = {law};
  return scene;
}

Scene<2> one_law(const ContactLaw& law) {
  Scene<2> scene;
  scene.materials = {"m"};
  scene.laws = {law};
  return scene;
}

}  // namespace bipot
