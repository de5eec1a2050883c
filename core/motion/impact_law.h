#pragma once

#include "core/motion/midpoint.h"

namespace bipot {

// Laws of impact beside Newton's: ContactLaw::Impact, data/manual/explanation/method.md §3.

/// A copy of the scene whose steps are assembled with other coefficients: 1 for Frémond's law,
/// which holds for the mean of the velocities before and after, 0 for Poisson's.
template <int D>
Scene<D> with_step_laws(const Scene<D>& scene);

/// Frémond's restitution, for a step assembled with_step_laws(): the law holds for
///   ũ_n = (u_n⁺ + u_n⁻)/2 + (1 - e_n)/2 max(-u_n⁻, 0),   ũ_t = (u_t⁺ + u_t⁻)/2.
/// A closing contact leaves with -e_n u_n⁻, and no contact ever gives energy. `scene`: the given
/// one. (Frémond, Phys. Lett. A 204, 1995; this form [ours])
template <int D>
void add_mean_restitution(const Scene<D>& scene, const State<D>& start, const Midpoint<D>& mid,
                          AssembledStep& step);

/// False where contacts close no faster than earlier steps, solved to `tol`, may have left them:
/// then Poisson's law has no compression. Compared is Σ ½ (u_n⁻)²/W_nn before and with the forces
/// of the step, as in the criterion. `step`: assembled with_step_laws().
bool has_compression(const AssembledStep& step, double tol);

/// First phase of Poisson's law: u = W s + u⁻, without forces. `step`: assembled with_step_laws().
template <int D>
ContactProblem compression_problem(const State<D>& start, const Midpoint<D>& mid,
                                   const AssembledStep& step);

/// e_n s_n of the compression's impulses s, one for each contact: what the expansion gives at least.
template <int D>
Vector returned_impulses(const Scene<D>& scene, const State<D>& start, const Midpoint<D>& mid,
                         const ContactProblem& problem, const Vector& compression);

/// Second phase: s_n >= `returned`, u_n >= 0 with one equality, and friction on the whole of s_n.
/// The first contacts are those of the problem `step`, with the excess s_n - returned. Then comes
/// one for each returned impulse with friction. Its normal row belongs to a mass that nothing else
/// touches, so that its normal impulse is the returned one.
///
/// With e the largest e_n, q = s, c: compression, a sum over contacts where none is written, the
/// two phases without forces change the energy by at most
///   -(1+e) μ s_n^c|u_t^c| - ½(1-e²) s^c·W s^c + Σ (e - e_n) μ s_n^c|u_t⁺|,
/// hence never increase it where one e_n holds for all. Without friction see method.md.
ContactProblem expansion_problem(const ContactProblem& step, const Vector& compression,
                                 const Vector& returned);

/// The impulses of both phases, m values; `expansion`: those of expansion_problem().
Vector impulses_of_phases(const ContactProblem& step, const Vector& compression,
                          const Vector& returned, const Vector& expansion);

}  // namespace bipot
