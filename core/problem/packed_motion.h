#pragma once

#include "core/problem/packed_bodies.h"

namespace bipot {

// Products with the packed H of disks and spheres, contact by contact.

/// The velocity of a body, or the impulses on it: x, y (z), padding, and a ω from kSpin on.
template <int D>
struct BodyPlace {
  static constexpr int kSize = D == 3 ? 8 : 4, kSpin = D == 3 ? 4 : 2;
  static constexpr int kForces = D == 3 ? 3 : 2, kTorques = D == 3 ? 3 : D - 1;
};

/// The impulse of a contact, and its moment on both bodies.
template <int D>
struct Push {
  double force[3] = {0, 0, 0}, spin[3] = {0, 0, 0};

  /// Adds to a body: `along` times the force, `about` times the moment. `along` is negative for
  /// body j.
  void add(double along, double about, double* v) const {
    for (int x = 0; x < BodyPlace<D>::kForces; ++x) v[x] += along * force[x];
    for (int x = 0; x < BodyPlace<D>::kTorques; ++x) v[BodyPlace<D>::kSpin + x] -= about * spin[x];
  }
};
template <int D>
inline Push<D> push(const DiskStructure::Contact& c, const double* s) {
  const double normal = c.normal * s[0];
  Push<D> p{{normal * c.n[0], normal * c.n[1]}};
  if constexpr (D == 2) {
    p.spin[0] = c.tangential * s[1];
    p.force[0] -= p.spin[0] * c.n[1];
    p.force[1] += p.spin[0] * c.n[0];
  }
  return p;
}
inline void cross(const double* a, const double* b, double* to) {
  to[0] = a[1] * b[2] - a[2] * b[1];
  to[1] = a[2] * b[0] - a[0] * b[2];
  to[2] = a[0] * b[1] - a[1] * b[0];
}
template <int D>
inline Push<D> push(const SphereStructure::Contact& c, const double* s) {
  const double normal = c.normal * s[0], t1 = c.tangential * s[1], t2 = c.tangential * s[2];
  Push<D> p;
  double tangential[3];
  for (int x = 0; x < 3; ++x) {
    tangential[x] = t1 * c.frame[1][x] + t2 * c.frame[2][x];
    p.force[x] = normal * c.frame[0][x] + tangential[x];
  }
  cross(c.frame[0], tangential, p.spin);
  return p;
}

/// Calls put(row, w) for the velocities of a contact between bodies with the values vi, vj.
template <int D, class Put>
inline void relative_velocity(const DiskStructure::Contact& c, const double* vi, const double* vj,
                              const Put& put) {
  const double x = vi[0] - vj[0], y = vi[1] - vj[1];
  put(0, c.normal * (c.n[0] * x + c.n[1] * y));
  if constexpr (D == 2) {
    put(1, c.tangential * (c.n[0] * y - c.n[1] * x - (vi[2] + vj[2])));
  }
}
template <int D, class Put>
inline void relative_velocity(const SphereStructure::Contact& c, const double* vi, const double* vj,
                              const Put& put) {
  // (n x t)·w = t·(w x n).
  double v[3], w[3], turned[3];
  for (int x = 0; x < 3; ++x) {
    v[x] = vi[x] - vj[x];
    w[x] = vi[BodyPlace<D>::kSpin + x] + vj[BodyPlace<D>::kSpin + x];
  }
  cross(w, c.frame[0], turned);
  const auto along = [&](int k, const double* of) {
    return c.frame[k][0] * of[0] + c.frame[k][1] * of[1] + c.frame[k][2] * of[2];
  };
  put(0, c.normal * along(0, v));
  for (int x = 0; x < 3; ++x) v[x] -= turned[x];
  put(1, c.tangential * along(1, v));
  put(2, c.tangential * along(2, v));
}

}  // namespace bipot
