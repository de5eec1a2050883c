#include "core/motion/force_balance.h"

#include <algorithm>
#include <cmath>

namespace bipot {

ForceBalance force_balance(const Scene& scene, const State& state) {
  const std::size_t disks = state.disks.size();
  std::vector<Vec2> force(disks);
  std::vector<double> moment(disks, 0.0);
  ForceBalance balance;
  balance.wall.assign(state.walls.size(), Vec2::Zero());
  for (std::size_t i = 0; i < disks; ++i) {
    force[i] = state.disks[i].mass * scene.gravity;
    balance.weight += force[i].norm();
  }
  for (const ContactOutcome& c : state.contacts) {
    const Vec2 t(-c.contact.n[1], c.contact.n[0]);
    const Vec2 f = (c.s_n * c.contact.n + c.s_t * t) / scene.step;
    const std::size_t i = static_cast<std::size_t>(c.contact.i);
    const std::size_t j = static_cast<std::size_t>(c.contact.j);
    // The lever from the centre of i to the contact is -a n, from that of j +a n.
    force[i] += f;
    moment[i] -= state.disks[i].radius * c.s_t / scene.step;
    if (j < disks) {
      force[j] -= f;
      moment[j] -= state.disks[j].radius * c.s_t / scene.step;
    } else {
      balance.wall[j - disks] += f;
      balance.walls += f;
    }
  }
  for (std::size_t i = 0; i < disks; ++i) {
    const double weight = state.disks[i].mass * scene.gravity.norm();
    balance.force = std::max(balance.force, force[i].norm() / weight);
    balance.moment =
        std::max(balance.moment, std::abs(moment[i]) / (weight * state.disks[i].radius));
  }
  return balance;
}

}  // namespace bipot
