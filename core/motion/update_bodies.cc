#include "core/motion/update_bodies.h"

#include <utility>

#include "core/scene/cluster_motion.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

void set_spin(Disk& d, const Vector& v, int row) { d.spin = v[row]; }
void set_spin(Sphere& s, const Vector& v, int row) { s.spin = v.segment<3>(row); }

/// The update of clusters, whose disks go with them.
void move_clusters(const Midpoint& mid, const DofMap& dofs, const Vector& v, double h,
                   State& next) {
  if (mid.clusters.empty()) return;
  next.clusters = mid.clusters;
  for (std::size_t c = 0; c < next.clusters.bodies.size(); ++c) {
    next.clusters.bodies[c].v = mid.cluster_v_free[c];
  }
  for (std::size_t i = 0; i < next.disks.size(); ++i) {
    const int k = dofs.disk[i];
    if (k < 0 || next.disks[i].cluster < 0) continue;
    Cluster& cluster = next.clusters.bodies[to_size(next.disks[i].cluster)];
    cluster.v = v.segment<2>(k);
    cluster.spin = v[k + 2];
  }
  for (Cluster& cluster : next.clusters.bodies) drift(cluster, 0.5 * h);
  place_members(next.clusters, next.disks);
}

}  // namespace

template <int D>
StateIn<D> update_bodies(MidpointIn<D>& mid, const DofMap& dofs, const Vector& v, double h) {
  StateIn<D> next;
  next.disks = std::move(mid.disks);
  next.walls = mid.walls;
  for (std::size_t i = 0; i < next.disks.size(); ++i) {
    BodyIn<D>& d = next.disks[i];
    if (d.wall >= 0 || d.cluster >= 0) continue;
    const int k = dofs.disk[i];
    d.v = k < 0 ? mid.disk_v_free[i] : VecIn<D>(v.segment<D>(k));
    if (k >= 0 && dofs.per_disk > D) set_spin(d, v, k + D);
    drift(d, 0.5 * h);
  }
  if constexpr (D == 2) move_clusters(mid, dofs, v, h, next);
  for (std::size_t w = 0; w < next.walls.size(); ++w) {
    WallIn<D>& wall = next.walls[w];
    if (wall.motion == WallIn<D>::Motion::kDriven) {
      const double speed = dofs.wall[w] < 0 ? mid.wall_v_free[w] : v[dofs.wall[w]];
      wall.v = driven_velocity(wall, speed);
    }
    wall.a += 0.5 * h * wall.v;
    wall.b += 0.5 * h * wall.v;
  }
  for (BodyIn<D>& d : next.disks) {
    if (d.wall < 0) continue;
    d.v = next.walls[to_size(d.wall)].v;
    drift(d, 0.5 * h);
  }
  if (!mid.cell.periodic()) return next;
  next.cell = mid.cell;
  for (int k = 0; k < 3; ++k) {
    if (mid.cell.side(k).motion != CellSide::Motion::kDriven) continue;
    next.cell.side(k).speed = dofs.side[k] < 0 ? mid.side_v_free[k] : v[dofs.side[k]];
  }
  move_cell(next.cell, 0.5 * h);
  return next;
}

template State update_bodies(Midpoint&, const DofMap&, const Vector&, double);
template StateIn<3> update_bodies(MidpointIn<3>&, const DofMap&, const Vector&, double);

}  // namespace bipot
