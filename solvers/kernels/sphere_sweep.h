#pragma once

#include <vector>

#include "core/problem/contact_problem.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/packed_motion.h"

namespace bipot {

/// The two-pass form of contact_sweep.h for spheres (sphere_structure.h): 144 bytes for each
/// contact.
class SphereSweep {
 public:
  SphereSweep(const ContactProblem& p, const SphereStructure& spheres)
      : contacts_(spheres.contacts.size()), bodies_(spheres.bodies.size()) {
    for (std::size_t k = 0; k < bodies_.size(); ++k) bodies_[k].of = spheres.bodies[k];
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      contacts_[c].map = spheres.contacts[c];
      contacts_[c].b = local<3>(p.u_free, static_cast<int>(c));
    }
  }

  void reset(const Eigen::Ref<const Vector>& s) {
    for (Body& body : bodies_) body = {.of = body.of};
    for (int c = 0; c < static_cast<int>(contacts_.size()); ++c) {
      contacts_[to_size(c)].s.setZero();
      set(c, local<3>(s, c));
    }
  }
  const Vector& impulse() const {
    gathered_.resize(3 * static_cast<Eigen::Index>(contacts_.size()));
    Eigen::Index row = 0;
    for (const Contact& contact : contacts_) {
      gathered_.segment<3>(row) = contact.s;
      row += 3;
    }
    return gathered_;
  }
  Local<3> impulse(int c) const { return contacts_[to_size(c)].s; }

  Local<3> velocity(int c) const {
    const Contact& k = contacts_[to_size(c)];
    Local<3> u = k.b;
    relative_velocity<3>(k.map, bodies_[to_size(k.map.i)].velocity,
                         bodies_[to_size(k.map.j)].velocity,
                         [&](int row, double w) { u[row] += w; });
    return u;
  }
  /// Adds to the contact's velocity at s = 0 the effect of contacts elsewhere.
  void shift(int c, const Local<3>& by) { contacts_[to_size(c)].b += by; }
  void set(int c, const Local<3>& s) {
    Contact& k = contacts_[to_size(c)];
    const Local<3> change = s - k.s;
    k.s = s;
    const Push<3> p = push<3>(k.map, change.data());
    Body &i = bodies_[to_size(k.map.i)], &j = bodies_[to_size(k.map.j)];
    p.add(i.of.inverse_mass, i.of.inverse_inertia, i.velocity);
    p.add(-j.of.inverse_mass, j.of.inverse_inertia, j.velocity);
  }

 private:
  struct Contact {
    SphereStructure::Contact map;
    Local<3> b = Local<3>::Zero(), s = Local<3>::Zero();
  };
  struct Body {
    double velocity[to_size(BodyPlace<3>::kSize)] = {};
    SphereStructure::Body of;
  };

  std::vector<Contact> contacts_;
  std::vector<Body> bodies_;
  mutable Vector gathered_;
};

}  // namespace bipot
