#include "core/motion/outside_changes.h"

#include "core/scene/wall_motion.h"

namespace bipot {

template <int D>
OutsideChanges<D> outside_changes(const SceneIn<D>& scene, const StateIn<D>& before,
                                  const std::vector<WallIn<D>>& walls,
                                  const std::type_identity_t<VecIn<D>>& gravity,
                                  const StateIn<D>& after, double time) {
  OutsideChanges<D> changes;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    if (!has_schedule(scene.walls[w])) continue;
    changes.work += wall_kinetic_energy(walls[w]) - wall_kinetic_energy(before.walls[w]);
    changes.impulse += wall_momentum(walls[w]) - wall_momentum(before.walls[w]);
  }
  if (scene.tilt.rate == 0) return changes;
  const VecIn<D> at_start = gravity - gravity_at(scene, before.time);
  const VecIn<D> at_end = gravity_at(scene, time) - gravity;
  for (std::size_t i = 0; i < after.disks.size(); ++i) {
    changes.work -=
        after.disks[i].mass * (at_start.dot(before.disks[i].x) + at_end.dot(after.disks[i].x));
  }
  if constexpr (D == 2) {
    for (std::size_t c = 0; c < after.clusters.bodies.size(); ++c) {
      const Cluster &from = before.clusters.bodies[c], &to = after.clusters.bodies[c];
      changes.work -= to.mass * (at_start.dot(from.x) + at_end.dot(to.x));
    }
  }
  return changes;
}

template OutsideChanges<2> outside_changes(const Scene&, const State&, const std::vector<Wall>&,
                                           const Vec2&, const State&, double);
template OutsideChanges<3> outside_changes(const SceneIn<3>&, const StateIn<3>&,
                                           const std::vector<WallIn<3>>&, const Vec3&,
                                           const StateIn<3>&, double);

}  // namespace bipot
