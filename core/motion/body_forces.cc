#include "core/motion/body_forces.h"

#include <cmath>

namespace bipot {

namespace {

template <int D>
Vec<D> fluid_velocity(const Scene<D>& scene, const PeriodicCell& cell, const Vec<D>& x) {
  return scene.drag.velocity + in_dimensions<D>(homogeneous_velocity(cell, x.template head<2>()));
}

}  // namespace

template <int D>
void add_body_forces(const Scene<D>& scene, const PeriodicCell& cell, double middle,
                     std::span<const std::type_identity_t<Body<D>>> bodies,
                     std::vector<Vec<D>>& v_free) {
  const double h = scene.step;
  for (const BodyForce<D>& f : scene.forces) {
    const Vec<D> impulse = h * f.time_factor.mean(middle - 0.5 * h, middle + 0.5 * h) * f.force;
    for (std::size_t i = to_size(f.first); i <= to_size(f.last); ++i) {
      v_free[i] += impulse / bodies[i].mass;
    }
  }
  if (scene.drag.coefficient == 0) return;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body<D>& body = bodies[i];
    if (body.wall >= 0) continue;
    const double lost = h * scene.drag.coefficient * body.radius / body.mass;
    const double share = -std::expm1(-lost);
    const Vec<D> w = fluid_velocity(scene, cell, body.x);
    v_free[i] = body.v + share * (w - body.v) + share / lost * (v_free[i] - body.v);
  }
}

template <int D>
void add_force_accelerations(const Scene<D>& scene, const PeriodicCell& cell, double time,
                             std::span<const std::type_identity_t<Body<D>>> bodies,
                             std::vector<Vec<D>>& a) {
  for (const BodyForce<D>& f : scene.forces) {
    const Vec<D> force = f.time_factor.at(time) * f.force;
    for (std::size_t i = to_size(f.first); i <= to_size(f.last); ++i)
      a[i] += force / bodies[i].mass;
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body<D>& body = bodies[i];
    a[i] += scene.drag.coefficient * body.radius / body.mass *
            (fluid_velocity(scene, cell, body.x) - body.v);
  }
}

template void add_body_forces(const Scene<2>&, const PeriodicCell&, double, std::span<const Disk>,
                              std::vector<Vec2>&);
template void add_body_forces(const Scene<3>&, const PeriodicCell&, double, std::span<const Sphere>,
                              std::vector<Vec3>&);
template void add_force_accelerations(const Scene<2>&, const PeriodicCell&, double,
                                      std::span<const Disk>, std::vector<Vec2>&);
template void add_force_accelerations(const Scene<3>&, const PeriodicCell&, double,
                                      std::span<const Sphere>, std::vector<Vec3>&);

}  // namespace bipot
