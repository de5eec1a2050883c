#include "bench/scenes/force_energy.h"

#include <cmath>

namespace bipot {

double force_energy(const Scene& scene, const State& after) {
  double pushed = 0;
  for (const ContactOutcome& c : after.contacts) {
    if (to_size(c.contact.j) >= scene.disks.size()) pushed += std::hypot(c.s_n, c.s_t);
  }
  return 0.5 * scene.step * scene.gravity.norm() * pushed;
}

}  // namespace bipot
