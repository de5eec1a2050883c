#include "tests/support/scene_parts.h"

namespace bipot {

Wall half_plane(const Vec2& point, const Vec2& normal) {
  Wall wall;
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

Scene one_law(const ContactLaw& law) {
  Scene scene;
  scene.materials = {"m"};
  scene.laws = {law};
  return scene;
}

}  // namespace bipot
