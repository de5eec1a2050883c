#include "core/motion/midpoint.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/base/parallel.h"
#include "core/motion/body_forces.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/joints.h"
#include "core/scene/periodic_detection.h"
#include "core/scene/wall_motion.h"

namespace bipot {

namespace {

/// Sets the velocities without contact impulses of the clusters and their bodies: gravity exerts no
/// torque.
template <int D>
void free_clusters(Midpoint<D>& mid, double h) {
  if (mid.clusters.empty()) return;
  for (const Cluster<D>& cluster : mid.clusters.bodies) {
    mid.cluster_v_free.emplace_back(cluster.v + h * mid.gravity);
  }
  for (std::size_t i = 0; i < mid.bodies.size(); ++i) {
    const Body<D>& d = mid.bodies[i];
    if (d.cluster < 0) continue;
    const Vec<D> arm = d.x - mid.clusters.bodies[to_size(d.cluster)].x;
    mid.disk_v_free[i] = mid.cluster_v_free[to_size(d.cluster)] + swept(d.spin, arm);
  }
}

/// Largest speed of a body or wall before the step, or without contacts after it.
template <int D>
double largest_speed(const Midpoint<D>& mid, double h) {
  double speed = 0;
  for (std::size_t i = 0; i < mid.bodies.size(); ++i) {
    speed = std::max({speed, mid.bodies[i].v.norm(), mid.disk_v_free[i].norm()});
  }
  for (const Wall<D>& w : mid.walls) {
    const bool driven = w.motion == Wall<D>::Motion::kDriven;
    speed = std::max(speed, w.v.norm() + (driven ? h * std::abs(w.force) / w.mass : 0));
  }
  return speed;
}

/// Of pairs not in contact, keeps those that may meet before the next detection, a step later.
template <int D>
void keep_those_who_may_meet(const Scene<D>& scene, Midpoint<D>& mid) {
  const auto speed = [&](std::size_t body) {
    if (body < mid.bodies.size()) {
      return std::max(mid.bodies[body].v.norm(), mid.disk_v_free[body].norm());
    }
    const std::size_t w = body - mid.bodies.size();
    return std::max(mid.walls[w].v.norm(), std::abs(mid.wall_v_free[w]));
  };
  std::erase_if(mid.contacts, [&](const Contact<D>& c) {
    return c.gap > scene.detection_distance() &&
           c.gap > scene.step * (speed(to_size(c.i)) + speed(to_size(c.j)));
  });
}

/// Velocities of disks and walls after the step without contact impulses.
template <int D>
void free_bodies(const Scene<D>& scene, double middle, Midpoint<D>& mid, int threads) {
  const double h = scene.step;
  mid.disk_v_free.resize(mid.bodies.size());
  run_pieces(threads, static_cast<int>(mid.bodies.size()), [&](int begin, int end) {
    for (std::size_t i = to_size(begin); i < to_size(end); ++i) {
      mid.disk_v_free[i] = mid.bodies[i].v + h * mid.gravity;
    }
  });
  if (has_body_forces(scene))
    add_body_forces<D>(scene, mid.cell, middle, mid.bodies, mid.disk_v_free);
  mid.wall_v_free.assign(mid.walls.size(), 0.0);
  for (std::size_t w = 0; w < mid.walls.size(); ++w) {
    const Wall<D>& wall = mid.walls[w];
    if (wall.motion != Wall<D>::Motion::kDriven) continue;
    mid.wall_v_free[w] = driven_speed(wall) + h * wall.force / wall.mass;
  }
  for (std::size_t i = 0; i < mid.bodies.size(); ++i) {
    if (mid.bodies[i].wall < 0) continue;
    const std::size_t w = to_size(mid.bodies[i].wall);
    const bool driven = mid.walls[w].motion == Wall<D>::Motion::kDriven;
    mid.disk_v_free[i] =
        driven ? driven_velocity(mid.walls[w], mid.wall_v_free[w]) : mid.walls[w].v;
  }
}

/// Cohesion of each contact of a step; empty in scenes without. It acts up to the scene's detection
/// distance, and where the scene does not heal at bonds alone: contacts with cohesion in the step
/// before. `state`: before the step. At time 0 every contact is a bond.                     [N]
template <int D>
std::vector<double> cohesive_forces(const Scene<D>& scene, const Midpoint<D>& mid,
                                    const State<D>& state) {
  std::vector<double> forces;
  if (!scene.has_cohesion()) return forces;
  forces.reserve(mid.contacts.size());
  const bool all = scene.heal || state.time == 0;
  auto old = state.contacts.begin();
  for (const Contact<D>& c : mid.contacts) {
    while (old != state.contacts.end() && old->contact.pair() < c.pair()) ++old;
    const bool again = old != state.contacts.end() && old->contact.pair() == c.pair();
    const bool bond = all || (again && old->bonded);
    const double most = pair_law(scene, mid.bodies, mid.walls, c.i, c.j).cohesion;
    forces.push_back(bond && c.gap <= scene.detection_distance() ? most : 0.0);
  }
  return forces;
}

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

/// Moves everything to its place at mid-step, with the velocities before the step.
template <int D>
void place_bodies(const Scene<D>& scene, const State<D>& state, Midpoint<D>& mid, int threads) {
  const double h = scene.step;
  mid.bodies = state.bodies;
  const double middle = state.time + 0.5 * h;
  mid.walls = walls_at(scene.walls, state.walls, middle, h);
  mid.gravity = gravity_at(scene, middle);
  run_pieces(threads, static_cast<int>(mid.bodies.size()), [&](int begin, int end) {
    for (Body<D>& d : std::span(mid.bodies).subspan(to_size(begin), to_size(end - begin))) {
      if (d.wall >= 0) d.v = mid.walls[to_size(d.wall)].v;  // which may have started or stopped
      drift(d, 0.5 * h);
    }
  });
  if (!state.clusters.empty()) {
    mid.clusters = state.clusters;
    for (Cluster<D>& cluster : mid.clusters.bodies) drift(cluster, 0.5 * h);
    place_members(mid.clusters, mid.bodies);
  }
  for (Wall<D>& w : mid.walls) {
    w.a += 0.5 * h * w.v;
    w.b += 0.5 * h * w.v;
  }
}

template <int D>
Midpoint<D> free_midpoint(const Scene<D>& scene, const State<D>& state, int threads) {
  Midpoint<D> mid;
  place_bodies(scene, state, mid, threads);
  mid.cell = state.cell;
  move_cell(mid.cell, 0.5 * scene.step);
  free_bodies(scene, state.time + 0.5 * scene.step, mid, threads);
  free_clusters(mid, scene.step);
  return mid;
}

template <int D>
Midpoint<D> make_midpoint(const Scene<D>& scene, const State<D>& state, int threads,
                          KeptContacts<D>* kept) {
  const double h = scene.step;
  Midpoint<D> mid = free_midpoint(scene, state, threads);
  if (state.cell.periodic()) {
    for (int k = 0; k < 3; ++k) {
      const CellSide& side = mid.cell.side(k);
      mid.side_v_free[k] = side.speed;
      if (side.motion == CellSide::Motion::kDriven) {
        mid.side_v_free[k] += h * stress_force(mid.cell, k) / side.mass;
      }
    }
    mid.contacts = detect_periodic_contacts(mid.bodies, mid.walls, mid.cell,
                                            scene.detection_distance(), threads);
  } else if (scene.predict_gaps) {
    const double reach = std::max(scene.detection_distance(), 2 * h * largest_speed<D>(mid, h));
    mid.contacts = detect_contacts<D>(mid.bodies, mid.walls, reach, threads);
  } else if (kept != nullptr) {
    mid.contacts = (*kept)(mid.bodies, mid.walls, scene.detection_distance(), threads);
  } else {
    mid.contacts = detect_contacts<D>(mid.bodies, mid.walls, scene.detection_distance(), threads);
  }
  leave_out_pinned(scene, mid.contacts);
  if (scene.predict_gaps) keep_those_who_may_meet(scene, mid);
  mid.cohesion = cohesive_forces(scene, mid, state);
  return mid;
}

template <int D>
AssembledStep assemble_step(const Scene<D>& scene, const Midpoint<D>& mid, int threads) {
  return assemble_step<D>({.scene = scene,
                           .bodies = mid.bodies,
                           .walls = mid.walls,
                           .contacts = mid.contacts,
                           .body_v_free = mid.disk_v_free,
                           .wall_v_free = mid.wall_v_free,
                           .cell = {&mid.cell, mid.side_v_free},
                           .clusters = {mid.clusters.bodies, mid.cluster_v_free},
                           .cohesion = mid.cohesion},
                          threads);
}

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

template void place_bodies(const Scene<2>&, const State<2>&, Midpoint<2>&, int);
template void place_bodies(const Scene<3>&, const State<3>&, Midpoint<3>&, int);
template Midpoint<2> free_midpoint(const Scene<2>&, const State<2>&, int);
template Midpoint<3> free_midpoint(const Scene<3>&, const State<3>&, int);
template Midpoint<2> make_midpoint(const Scene<2>&, const State<2>&, int, KeptContacts<2>*);
template Midpoint<3> make_midpoint(const Scene<3>&, const State<3>&, int, KeptContacts<3>*);
template AssembledStep assemble_step(const Scene<2>&, const Midpoint<2>&, int);
template AssembledStep assemble_step(const Scene<3>&, const Midpoint<3>&, int);
template State<2> update_bodies(Midpoint<2>&, const DofMap&, const Vector&, double);
template State<3> update_bodies(Midpoint<3>&, const DofMap&, const Vector&, double);

}  // namespace bipot
