#pragma once

#include "solvers/interior/interior_state.h"

namespace bipot {

/// Interior states all of whose eigenvalue products are equal: points where the central path of the
/// exact law is regular and known, at large products and next to an impulse. The path that starts
/// there (taylor_path.h) is the one whose limit is a solution; from uneven products it need not be.

/// Mean W_nn s_n² [J] of the impulses that hold the bodies, an energy with the problem's own scale.
/// The bodies are held by normal springs of stiffness kappa / W_nn, which may pull:
/// (I + R W) s = -R u_free, R = diag(kappa / W_nn, 0), kappa = 1e4 or the number of contacts where
/// that is more, so that the forces reach across. It grows with the weight that a packing carries
/// and costs one factorisation.
template <int D>
double spring_energy(InteriorSystem<D>& system);

/// Mean W_nn s_n² of an impulse s (m), [J].
template <int D>
double normal_energy(const InteriorSystem<D>& system, const Vector& s);

/// s_n = factor sqrt(energy / W_nn), s_t = 0, all products factor * energy. factor > 0, large ones
/// lie where the path is nearly straight.
template <int D>
InteriorState<D> cold_start(const InteriorSystem<D>& system, double energy, double factor);

/// The state of equal products tau > 0 [J] that solves, contact by contact, the smoothed law with
/// the other contacts held at s0 (m, need not be admissible): with z = s0 - u(s0) / W_cc,
///
///     W_nn (s_n - z_n) = tau / s_n,   W_tt (s_t - z_t) + (multiplier of |s_t| < mu s_n) = 0,
///
/// the multiplier being tau times the gradient of -log det x (contact_jordan.h). Small tau keeps
/// the force network of s0, though not its error.
template <int D>
InteriorState<D> warm_start(const InteriorSystem<D>& system, const Vector& s0, double tau);

extern template double spring_energy<1>(InteriorSystem<1>&);
extern template double spring_energy<2>(InteriorSystem<2>&);
extern template double spring_energy<3>(InteriorSystem<3>&);
extern template double normal_energy<1>(const InteriorSystem<1>&, const Vector&);
extern template double normal_energy<2>(const InteriorSystem<2>&, const Vector&);
extern template double normal_energy<3>(const InteriorSystem<3>&, const Vector&);
extern template InteriorState<1> cold_start<1>(const InteriorSystem<1>&, double, double);
extern template InteriorState<2> cold_start<2>(const InteriorSystem<2>&, double, double);
extern template InteriorState<3> cold_start<3>(const InteriorSystem<3>&, double, double);
extern template InteriorState<1> warm_start<1>(const InteriorSystem<1>&, const Vector&, double);
extern template InteriorState<2> warm_start<2>(const InteriorSystem<2>&, const Vector&, double);
extern template InteriorState<3> warm_start<3>(const InteriorSystem<3>&, const Vector&, double);

}  // namespace bipot
