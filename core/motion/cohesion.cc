#include "core/motion/cohesion.h"

#include <utility>

namespace bipot {

template <int D>
std::vector<double> cohesive_forces(const Scene<D>& scene,
                                    std::span<const std::type_identity_t<Body<D>>> bodies,
                                    std::span<const std::type_identity_t<Wall<D>>> walls,
                                    std::span<const std::type_identity_t<Contact<D>>> contacts,
                                    const State<D>& state) {
  std::vector<double> forces;
  if (!scene.has_cohesion()) return forces;
  forces.reserve(contacts.size());
  const bool all = scene.heal || state.time == 0;
  auto old = state.contacts.begin();
  for (const Contact<D>& c : contacts) {
    const std::pair key(c.i, c.j);
    const auto key_of = [](const ContactOutcome<D>& o) {
      return std::pair(o.contact.i, o.contact.j);
    };
    while (old != state.contacts.end() && key_of(*old) < key) ++old;
    const bool bond = all || (old != state.contacts.end() && key_of(*old) == key && old->bonded);
    const double most = pair_law(scene, bodies, walls, c.i, c.j).cohesion;
    forces.push_back(bond && c.gap <= scene.detection_distance() ? most : 0.0);
  }
  return forces;
}

template std::vector<double> cohesive_forces(const Scene<2>&, std::span<const Disk>,
                                             std::span<const Wall<2>>, std::span<const Contact<2>>,
                                             const State<2>&);
template std::vector<double> cohesive_forces(const Scene<3>&, std::span<const Sphere>,
                                             std::span<const Wall<3>>, std::span<const Contact<3>>,
                                             const State<3>&);

}  // namespace bipot
