#include "core/motion/force_balance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/scene/cluster_motion.h"

namespace bipot {
namespace {

/// Adds the forces on the disks of each cluster. The lever of a disk is its arm at mid-step, the
/// length scale the radius of a disk of the same area, or sphere of the same volume.
template <int D>
void balance_clusters(const Scene<D>& scene, const State<D>& state,
                      const std::vector<Vec<D>>& force, const std::vector<Spin<D>>& moment,
                      ForceBalance<D>& balance) {
  for (std::size_t c = 0; c < state.clusters.bodies.size(); ++c) {
    Cluster<D> cluster = state.clusters.bodies[c];
    drift(cluster, -0.5 * scene.step);
    Vec<D> sum = cluster.mass * scene.gravity;
    Spin<D> turned = no_turn<D>();
    for (std::size_t i = 0; i < state.bodies.size(); ++i) {
      if (state.bodies[i].cluster != static_cast<int>(c)) continue;
      sum += force[i];
      turned += moment[i] + arm_times(turned_arm(cluster, state.clusters.arms[i]), force[i]);
    }
    const double weight = cluster.mass * scene.gravity.norm();
    const double size = D == 2 ? std::sqrt(cluster.size / std::numbers::pi)
                               : std::cbrt(0.75 * cluster.size / std::numbers::pi);
    balance.weight += weight;
    balance.force = std::max(balance.force, sum.norm() / weight);
    balance.moment = std::max(balance.moment, magnitude(turned) / (weight * size));
  }
}

}  // namespace

template <int D>
std::vector<Vec<D>> wall_reactions(const State<D>& state, double step) {
  std::vector<Vec<D>> reactions(state.walls.size(), Vec<D>::Zero());
  for (const ContactOutcome<D>& c : state.contacts) {
    const Vec<D> f = (c.s_n * c.contact.n + tangent_vector(c.contact.n, c.s_t)) / step;
    const auto add = [&](int body, const Vec<D>& force) {
      const int wall = wall_of(state.bodies, body);
      if (wall >= 0) reactions[to_size(wall)] += force;
    };
    add(c.contact.i, f);
    add(c.contact.j, -f);
  }
  return reactions;
}

template <int D>
ForceBalance<D> force_balance(const Scene<D>& scene, const State<D>& state) {
  const std::size_t disks = state.bodies.size();
  std::vector<Vec<D>> force(disks);
  std::vector<Spin<D>> moment(disks, no_turn<D>());
  ForceBalance<D> balance;
  balance.wall.assign(state.walls.size(), Vec<D>::Zero());
  for (std::size_t i = 0; i < disks; ++i) {
    force[i] = state.bodies[i].mass * scene.gravity;
    balance.weight += force[i].norm();
  }
  for (const ContactOutcome<D>& c : state.contacts) {
    const Vec<D>& n = c.contact.n;
    const Vec<D> f = (c.s_n * n + tangent_vector(n, c.s_t)) / scene.step;
    const Spin<D> turned = turning(n, c.s_t);
    const std::size_t i = static_cast<std::size_t>(c.contact.i);
    const std::size_t j = static_cast<std::size_t>(c.contact.j);
    // The lever from the centre of i to the contact is -a n, that from the centre of j +a n.
    force[i] += f;
    moment[i] -= (state.bodies[i].radius * turned - c.moment) / scene.step;
    if (j < disks) {
      force[j] -= f;
      moment[j] -= (state.bodies[j].radius * turned + c.moment) / scene.step;
    } else {
      balance.wall[j - disks] += f;
      balance.walls += f;
    }
  }
  balance_clusters<D>(scene, state, force, moment, balance);
  for (std::size_t i = 0; i < disks; ++i) {
    if (state.bodies[i].wall >= 0 || state.bodies[i].cluster >= 0) continue;  // held by others
    const double weight = state.bodies[i].mass * scene.gravity.norm();
    balance.force = std::max(balance.force, force[i].norm() / weight);
    balance.moment =
        std::max(balance.moment, magnitude(moment[i]) / (weight * state.bodies[i].radius));
  }
  return balance;
}

template std::vector<Vec2> wall_reactions(const State<2>&, double);
template std::vector<Vec3> wall_reactions(const State<3>&, double);
template ForceBalance<2> force_balance(const Scene<2>&, const State<2>&);
template ForceBalance<3> force_balance(const Scene<3>&, const State<3>&);

}  // namespace bipot
