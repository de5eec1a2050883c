#include "core/motion/update_bodies.h"

#include <utility>

#include "core/scene/cluster_motion.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

void set_spin(Disk& d, const Vector& v, int row) { d.spin = v[row]; }
void set_spin(Sphere& s, const Vector& v, int row) { s.spin = v.segment<3>(row); }

/// Updates clusters and their bodies.
template <int D>
void move_clusters(const Midpoint<D>& mid, const DofMap& dofs, const Vector& v, double h,
                   State<D>& next) {
  if (mid.clusters.empty()) return;
  next.clusters = mid.clusters;
  for (std::size_t c = 0; c < next.clusters.bodies.size(); ++c) {
    next.clusters.bodies[c].v = mid.cluster_v_free[c];
  }
  for (std::size_t i = 0; i < next.bodies.size(); ++i) {
    const int k = dofs.disk[i];
    if (k < 0 || next.bodies[i].cluster < 0) continue;
    Cluster<D>& cluster = next.clusters.bodies[to_size(next.bodies[i].cluster)];
    cluster.v = v.segment<D>(k);
    set_own_spin(cluster, v, k + D);
  }
  for (Cluster<D>& cluster : next.clusters.bodies) drift(cluster, 0.5 * h);
  place_members(next.clusters, next.bodies);
}

}  // namespace

template <int D>
State<D> update_bodies(Midpoint<D>& mid, const DofMap& dofs, const Vector& v, double h) {
  State<D> next;
  next.bodies = std::move(mid.bodies);
  next.walls = mid.walls;
  for (std::size_t i = 0; i < next.bodies.size(); ++i) {
    Body<D>& d = next.bodies[i];
    if (d.wall >= 0 || d.cluster >= 0) continue;
    const int k = dofs.disk[i];
    d.v = k < 0 ? mid.disk_v_free[i] : Vec<D>(v.segment<D>(k));
    if (k >= 0 && dofs.per_disk > D) set_spin(d, v, k + D);
    drift(d, 0.5 * h);
  }
  move_clusters(mid, dofs, v, h, next);
  for (std::size_t w = 0; w < next.walls.size(); ++w) {
    Wall<D>& wall = next.walls[w];
    if (wall.motion == Wall<D>::Motion::kDriven) {
      const double speed = dofs.wall[w] < 0 ? mid.wall_v_free[w] : v[dofs.wall[w]];
      wall.v = driven_velocity(wall, speed);
    }
    wall.a += 0.5 * h * wall.v;
    wall.b += 0.5 * h * wall.v;
  }
  for (Body<D>& d : next.bodies) {
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

template State<2> update_bodies(Midpoint<2>&, const DofMap&, const Vector&, double);
template State<3> update_bodies(Midpoint<3>&, const DofMap&, const Vector&, double);

}  // namespace bipot
