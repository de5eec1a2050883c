#include "solvers/simulation/force_energy.h"

#include <cmath>

namespace bipot {

template <int D>
double force_energy(const Scene<D>& scene, double wall_pushes) {
  return 0.5 * scene.step * scene.gravity.norm() * wall_pushes;
}

template <int D>
double force_energy(const Scene<D>& scene, const State<D>& after) {
  double pushed = 0;
  for (const ContactOutcome<D>& c : after.contacts) {
    if (to_size(c.contact.j) >= after.bodies.size()) pushed += std::hypot(c.s_n, magnitude(c.s_t));
  }
  return force_energy(scene, pushed);
}

template double force_energy(const Scene<2>&, double);
template double force_energy(const Scene<3>&, double);
template double force_energy(const Scene<2>&, const State<2>&);
template double force_energy(const Scene<3>&, const State<3>&);

}  // namespace bipot
