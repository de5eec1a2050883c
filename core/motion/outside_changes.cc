#include "core/motion/outside_changes.h"

#include "core/scene/wall_motion.h"

namespace bipot {

template <int D>
OutsideChanges<D> outside_changes(const SceneIn<D>& scene, const StateIn<D>& before,
                                  const std::vector<WallIn<D>>& walls,
                                  const std::type_identity_t<VecIn<D>>& gravity,
                                  const std::vector<BodyIn<D>>& disks, double time) {
  OutsideChanges<D> changes;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    if (!has_schedule(scene.walls[w])) continue;
    changes.work += wall_kinetic_energy(walls[w]) - wall_kinetic_energy(before.walls[w]);
    changes.impulse += wall_momentum(walls[w]) - wall_momentum(before.walls[w]);
  }
  if (scene.tilt.rate == 0) return changes;
  const VecIn<D> at_start = gravity - gravity_at(scene, before.time);
  const VecIn<D> at_end = gravity_at(scene, time) - gravity;
  for (std::size_t i = 0; i < disks.size(); ++i) {
    changes.work -= disks[i].mass * (at_start.dot(before.disks[i].x) + at_end.dot(disks[i].x));
  }
  return changes;
}

template OutsideChanges<2> outside_changes(const Scene&, const State&, const std::vector<Wall>&,
                                           const Vec2&, const std::vector<Disk>&, double);
template OutsideChanges<3> outside_changes(const SceneIn<3>&, const StateIn<3>&,
                                           const std::vector<WallIn<3>>&, const Vec3&,
                                           const std::vector<Sphere>&, double);

}  // namespace bipot
