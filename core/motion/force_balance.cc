#include "core/motion/force_balance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/scene/cluster_motion.h"

namespace bipot {
namespace {

/// Adds the forces on the disks of each cluster. The lever of a disk is its arm at mid-step, the
/// length scale the radius of a disk of the same area.
void balance_clusters(const Scene<2>& scene, const State<2>& state, const std::vector<Vec2>& force,
                      const std::vector<double>& moment, ForceBalance<2>& balance) {
  for (std::size_t c = 0; c < state.clusters.bodies.size(); ++c) {
    Cluster cluster = state.clusters.bodies[c];
    drift(cluster, -0.5 * scene.step);
    Vec2 sum = cluster.mass * scene.gravity;
    double turned = 0;
    for (std::size_t i = 0; i < state.bodies.size(); ++i) {
      if (state.bodies[i].cluster != static_cast<int>(c)) continue;
      const Vec2 arm = turned_arm(cluster, state.clusters.arms[i]);
      sum += force[i];
      turned += moment[i] + arm[0] * force[i][1] - arm[1] * force[i][0];
    }
    const double weight = cluster.mass * scene.gravity.norm();
    const double size = std::sqrt(cluster.area / std::numbers::pi);
    balance.weight += weight;
    balance.force = std::max(balance.force, sum.norm() / weight);
    balance.moment = std::max(balance.moment, std::abs(turned) / (weight * size));
  }
}

}  // namespace

template <int D>
std::vector<Vec<D>> wall_reactions(const State<D>& state, double step) {
  std::vector<Vec<D>> reactions(state.walls.size(), Vec<D>::Zero());
  const auto bodies = static_cast<int>(state.bodies.size());
  for (const ContactOutcome<D>& c : state.contacts) {
    const Vec<D> f = (c.s_n * c.contact.n + tangent_vector(c.contact.n, c.s_t)) / step;
    const auto add = [&](int body, const Vec<D>& force) {
      const int wall = body < bodies ? state.bodies[to_size(body)].wall : body - bodies;
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
  if constexpr (D == 2) {
    if (!state.clusters.empty()) balance_clusters(scene, state, force, moment, balance);
  }
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
