#include "core/motion/midpoint.h"

#include "core/scene/contact_detection.h"

namespace bipot {

template <int D>
MidpointIn<D> make_midpoint(const SceneIn<D>& scene, const StateIn<D>& state, int threads) {
  const double h = scene.step;
  MidpointIn<D> mid;
  mid.disks = state.disks;
  mid.walls = state.walls;
  for (BodyIn<D>& d : mid.disks) drift(d, 0.5 * h);
  for (WallIn<D>& w : mid.walls) {
    w.a += 0.5 * h * w.v;
    w.b += 0.5 * h * w.v;
  }
  mid.contacts = detect_contacts<D>(mid.disks, mid.walls, scene.contact_distance, threads);

  mid.disk_v_free.resize(mid.disks.size());
  for (std::size_t i = 0; i < mid.disks.size(); ++i) {
    mid.disk_v_free[i] = mid.disks[i].v + h * scene.gravity;
  }
  mid.wall_v_free.assign(mid.walls.size(), 0.0);
  for (std::size_t w = 0; w < mid.walls.size(); ++w) {
    const WallIn<D>& wall = mid.walls[w];
    if (wall.motion != WallIn<D>::Motion::kDriven) continue;
    mid.wall_v_free[w] = wall.v.dot(wall.direction) + h * wall.force / wall.mass;
  }
  return mid;
}

template <int D>
AssembledStep assemble_step(const SceneIn<D>& scene, const MidpointIn<D>& mid,
                            bool explicit_delassus, int threads) {
  return assemble_step(scene, mid.disks, mid.walls, mid.contacts, mid.disk_v_free, mid.wall_v_free,
                       explicit_delassus, threads);
}

template Midpoint make_midpoint(const Scene&, const State&, int);
template MidpointIn<3> make_midpoint(const SceneIn<3>&, const StateIn<3>&, int);
template AssembledStep assemble_step(const Scene&, const Midpoint&, bool, int);
template AssembledStep assemble_step(const SceneIn<3>&, const MidpointIn<3>&, bool, int);

}  // namespace bipot
