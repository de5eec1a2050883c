#include "core/motion/midpoint.h"

#include "core/scene/contact_detection.h"

namespace bipot {

Midpoint make_midpoint(const Scene& scene, const State& state, int threads) {
  const double h = scene.step;
  Midpoint mid;
  mid.disks = state.disks;
  mid.walls = state.walls;
  for (Disk& d : mid.disks) {
    d.x += 0.5 * h * d.v;
    d.angle += 0.5 * h * d.spin;
  }
  for (Wall& w : mid.walls) {
    w.a += 0.5 * h * w.v;
    w.b += 0.5 * h * w.v;
  }
  mid.contacts = detect_contacts(mid.disks, mid.walls, scene.contact_distance, threads);

  mid.disk_v_free.resize(mid.disks.size());
  for (std::size_t i = 0; i < mid.disks.size(); ++i) {
    mid.disk_v_free[i] = mid.disks[i].v + h * scene.gravity;
  }
  mid.wall_v_free.assign(mid.walls.size(), 0.0);
  for (std::size_t w = 0; w < mid.walls.size(); ++w) {
    const Wall& wall = mid.walls[w];
    if (wall.motion != Wall::Motion::kDriven) continue;
    mid.wall_v_free[w] = wall.v.dot(wall.direction) + h * wall.force / wall.mass;
  }
  return mid;
}

AssembledStep assemble_step(const Scene& scene, const Midpoint& mid, bool explicit_delassus,
                            int threads) {
  return assemble_step(scene, mid.disks, mid.walls, mid.contacts, mid.disk_v_free, mid.wall_v_free,
                       explicit_delassus, threads);
}

}  // namespace bipot
