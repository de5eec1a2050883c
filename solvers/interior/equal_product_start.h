#pragma once

#include "solvers/interior/interior_state.h"

namespace bipot {

/// Interior states with equal eigenvalue products. There the central path of the exact law is
/// regular and known, at large products and next to an impulse. A path from such a state
/// (taylor_path.h) ends at a solution; from unequal products it need not.
template <ContactRows D>
struct EqualProductStart {
  InteriorSystem<D>& system;

  /// Mean W_nn s_n² of the impulses that hold the bodies, the problem's own scale of energy [J].
  /// The bodies are held by normal springs of stiffness kappa / W_nn, which may pull:
  ///   (I + R W) s = -R u_free,   R = diag(kappa / W_nn, 0),   kappa = max(1e4, contacts),
  /// so that forces reach across the packing. The energy grows with the weight that a packing
  /// carries. It costs one factorisation.
  double spring_energy();

  /// Mean W_nn s_n² of an impulse s (m), [J].
  double normal_energy(const Vector& s) const;

  /// s_n = factor sqrt(energy / W_nn), s_t = 0, all products factor * energy. factor > 0; for large
  /// ones the path is nearly straight.
  InteriorState<D> cold(double energy, double factor) const;

  /// The state of equal products tau > 0 [J] that solves, contact by contact, the smoothed law with
  /// the other contacts fixed at s0 (m, need not be admissible). With z = s0 - u(s0) / W_cc,
  ///
  ///     W_nn (s_n - z_n) = tau / s_n,   W_tt (s_t - z_t) + (multiplier of |s_t| < mu s_n) = 0.
  ///
  /// The multiplier is tau times the gradient of -log det x (contact_jordan.h). Small tau keeps the
  /// force network of s0, though not its error.
  InteriorState<D> warm(const Vector& s0, double tau) const;
};
template <ContactRows D>  // clang 14 does not deduce it
EqualProductStart(InteriorSystem<D>&)->EqualProductStart<D>;

}  // namespace bipot
