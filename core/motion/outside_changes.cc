#include "core/motion/outside_changes.h"

#include "core/motion/body_forces.h"
#include "core/scene/wall_motion.h"

namespace bipot {

template <int D>
OutsideChanges<D> outside_changes(const Scene<D>& scene, const State<D>& before,
                                  const std::vector<Wall<D>>& walls,
                                  const std::type_identity_t<Vec<D>>& gravity,
                                  std::span<const std::type_identity_t<Vec<D>>> v_free,
                                  const State<D>& after) {
  OutsideChanges<D> changes;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    if (!has_schedule(scene.walls[w])) continue;
    changes.work += wall_kinetic_energy(walls[w]) - wall_kinetic_energy(before.walls[w]);
    changes.impulse += wall_momentum(walls[w]) - wall_momentum(before.walls[w]);
  }
  if (has_body_forces(scene)) {
    for (std::size_t i = 0; i < after.bodies.size(); ++i) {
      const Body<D>& d = before.bodies[i];
      const Vec<D> impulse = d.mass * (v_free[i] - d.v - scene.step * gravity);
      changes.work += 0.5 * impulse.dot(d.v + after.bodies[i].v);
      changes.impulse += impulse;
    }
  }
  if (scene.tilt.rate == 0) return changes;
  const Vec<D> at_start = gravity - gravity_at(scene, before.time);
  const Vec<D> at_end = gravity_at(scene, after.time) - gravity;
  for (std::size_t i = 0; i < after.bodies.size(); ++i) {
    changes.work -=
        after.bodies[i].mass * (at_start.dot(before.bodies[i].x) + at_end.dot(after.bodies[i].x));
  }
  for (std::size_t c = 0; c < after.clusters.bodies.size(); ++c) {
    const Cluster<D>&from = before.clusters.bodies[c], &to = after.clusters.bodies[c];
    changes.work -= to.mass * (at_start.dot(from.x) + at_end.dot(to.x));
  }
  return changes;
}

template OutsideChanges<2> outside_changes(const Scene<2>&, const State<2>&,
                                           const std::vector<Wall<2>>&, const Vec2&,
                                           std::span<const Vec2>, const State<2>&);
template OutsideChanges<3> outside_changes(const Scene<3>&, const State<3>&,
                                           const std::vector<Wall<3>>&, const Vec3&,
                                           std::span<const Vec3>, const State<3>&);

}  // namespace bipot
