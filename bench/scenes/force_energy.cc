#include "bench/scenes/force_energy.h"

#include <cmath>

namespace bipot {

template <int D>
double force_energy(const SceneIn<D>& scene, double wall_pushes) {
  return 0.5 * scene.step * scene.gravity.norm() * wall_pushes;
}

template <int D>
double force_energy(const SceneIn<D>& scene, const StateIn<D>& after) {
  double pushed = 0;
  for (const ContactOutcomeIn<D>& c : after.contacts) {
    if (to_size(c.contact.j) >= after.disks.size()) pushed += std::hypot(c.s_n, magnitude(c.s_t));
  }
  return force_energy(scene, pushed);
}

template double force_energy(const Scene&, double);
template double force_energy(const SceneIn<3>&, double);
template double force_energy(const Scene&, const State&);
template double force_energy(const SceneIn<3>&, const StateIn<3>&);

}  // namespace bipot
