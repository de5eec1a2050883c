#include "core/motion/force_balance.h"

#include <algorithm>
#include <cmath>

namespace bipot {

template <int D>
ForceBalanceIn<D> force_balance(const SceneIn<D>& scene, const StateIn<D>& state) {
  const std::size_t disks = state.disks.size();
  std::vector<VecIn<D>> force(disks);
  std::vector<SpinIn<D>> moment(disks, no_turn<D>());
  ForceBalanceIn<D> balance;
  balance.wall.assign(state.walls.size(), VecIn<D>::Zero());
  for (std::size_t i = 0; i < disks; ++i) {
    force[i] = state.disks[i].mass * scene.gravity;
    balance.weight += force[i].norm();
  }
  for (const ContactOutcomeIn<D>& c : state.contacts) {
    const VecIn<D>& n = c.contact.n;
    const VecIn<D> f = (c.s_n * n + tangent_vector(n, c.s_t)) / scene.step;
    const SpinIn<D> turned = turning(n, c.s_t);
    const std::size_t i = static_cast<std::size_t>(c.contact.i);
    const std::size_t j = static_cast<std::size_t>(c.contact.j);
    // The lever from the centre of i to the contact is -a n, from that of j +a n.
    force[i] += f;
    moment[i] -= state.disks[i].radius * turned / scene.step;
    if (j < disks) {
      force[j] -= f;
      moment[j] -= state.disks[j].radius * turned / scene.step;
    } else {
      balance.wall[j - disks] += f;
      balance.walls += f;
    }
  }
  for (std::size_t i = 0; i < disks; ++i) {
    if (state.disks[i].wall >= 0) continue;  // held by its wall
    const double weight = state.disks[i].mass * scene.gravity.norm();
    balance.force = std::max(balance.force, force[i].norm() / weight);
    balance.moment =
        std::max(balance.moment, magnitude(moment[i]) / (weight * state.disks[i].radius));
  }
  return balance;
}

template ForceBalance force_balance(const Scene&, const State&);
template ForceBalanceIn<3> force_balance(const SceneIn<3>&, const StateIn<3>&);

}  // namespace bipot
