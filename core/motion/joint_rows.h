#pragma once

#include <span>
#include <type_traits>

#include "core/motion/assembly.h"
#include "core/motion/step_outcome.h"

namespace bipot {

// Pins and ropes in the problem of a step. The next midpoint lies h v⁺ after this one, and a spin w
// turns a body by h w on the way. So the gap c of a pin becomes
//
//     c + h G v⁺ + (R(h w⁻) - 1 - h w⁻ x) arms
//
// to the third order in h, and exactly if the body turns evenly. This is 0: rows of G v⁺. For the
// gap g of a rope, its length less the distance of its ends, the way of the ends is taken likewise:
// a contact without friction with u_n + (g at the next midpoint)/h >= 0. Then at midpoints the gap
// is of the third order, whatever the number of steps: nothing adds up. A state lies between two
// midpoints: there a point that runs at v on a circle of radius l is h² v²/(8 l) inside it. This is
// one Newton step of SHAKE (Ryckaert, Ciccotti, Berendsen, J. Comput. Phys. 23, 1977). What it
// leaves, the next step puts right by a velocity of gap/h: where bodies turn too far in a step,
// this makes energy without end (solvers/simulation/joint_energy.h). [ours]

/// Adds the ropes to the problem, as its last contacts; for bodies at mid-step.
template <int D>
void add_ropes(const Scene<D>& scene, std::span<const std::type_identity_t<Body<D>>> bodies,
               const ClusterInput<D>& clusters, AssembledStep& step);

/// Puts the pins into the problem, as equality rows; for bodies at mid-step. Where pins contradict
/// each other, the nearest velocities are taken. A contact that pins leave no motion has no effect.
template <int D>
void add_pins(const Scene<D>& scene, std::span<const std::type_identity_t<Body<D>>> bodies,
              const ClusterInput<D>& clusters, AssembledStep& step);

/// Adds what the joints did in a step: s, v as of step_outcome(). What they dissipate, by shocks
/// and to rounding of the above, is a shock loss.
template <int D>
void add_joint_outcome(const AssembledStep& step, const Vector& s, const Vector& v,
                       StepOutcome<D>& outcome);

}  // namespace bipot
