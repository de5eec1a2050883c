#pragma once

#include <vector>

#include "core/problem/coulomb_cone.h"

namespace bipot {

/// Which contacts a sweep may leave out because they have settled: after kSettledVisits visits in a
/// row that changed the impulse by no more than `settled_below`, a contact is left out of the next
/// `sweeps` sweeps and looked at again after them. Nothing is ever left out for good, so that a
/// point where sweeps stand still is one of sweeps over all contacts; the stop test looks at all.
/// Siconos' NSGS has the same idea (SICONOS_FRICTION_3D_NSGS_FREEZING_CONTACT).
class FrozenContacts {
 public:
  static constexpr int kSettledVisits = 3;

  FrozenContacts(int contacts, int sweeps)
      : sweeps_(sweeps), asleep_(to_size(contacts), 0), settled_(to_size(contacts), 0) {}

  /// Calls visit(c) unless contact c is left out of this sweep; `impulse(c)` is read before and
  /// after the visit. True where it was visited.
  template <int D, class Impulse, class Visit>
  bool operator()(int c, double settled_below, const Impulse& impulse, const Visit& visit) {
    int& asleep = asleep_[to_size(c)];
    if (asleep > 0) {
      --asleep;
      return false;
    }
    const Local<D> before = impulse(c);
    visit(c);
    const double change = (impulse(c) - before).template lpNorm<Eigen::Infinity>();
    int& settled = settled_[to_size(c)];
    // NaN is no rest.
    settled = change <= settled_below ? settled + 1 : 0;
    if (settled >= kSettledVisits) asleep = sweeps_;
    return true;
  }

 private:
  int sweeps_;
  std::vector<int> asleep_, settled_;  // sweeps still to be left out of; visits without change
};

}  // namespace bipot
