#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/motion/midpoint.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// Status of a contact by its impulse; s_t is signed in 2D, a magnitude in 3D. It slides from
/// kConeEdge on.
ContactStatus contact_status(double s_n, double s_t, double mu);

/// Effects of the impulses of a nonsmooth step. Powers use the mean of the velocities before and
/// after the step, as the displacement does.
template <int D>
struct StepOutcome {
  std::vector<ContactOutcome<D>> contacts;  ///< one for each candidate, in their order
  int active = 0;                           ///< contacts with s_n > 0
  double wall_work = 0;                     ///< by walls and sides of a periodic cell     [J]
  double friction_loss = 0;                 ///< dissipated by tangential impulses         [J]
  double shock_loss = 0;                    ///< dissipated by normal impulses             [J]
  Vec<D> external = Vec<D>::Zero();  ///< impulse on disks and driven walls from all else [N s]
};

/// The effects of contacts alone, without gravity and driving forces. Arguments as of
/// step_outcome(). In parallel each process has its own contacts.
template <int D>
StepOutcome<D> contact_outcomes(const Scene<D>& scene, const Midpoint<D>& mid,
                                std::span<const std::type_identity_t<Body<D>>> disks,
                                const AssembledStep& assembled, const Vector& s, const Vector& v);

/// Adds the forces that drive these walls over the step, with the walls in the step and after it.
template <int D>
void add_driving_forces(double step, std::span<const std::type_identity_t<Wall<D>>> walls,
                        std::span<const std::type_identity_t<Wall<D>>> walls_after,
                        StepOutcome<D>& outcome);

/// `disks`: those of the step, for their masses, materials and walls; their positions do not
/// matter. s: impulses in the problem's variables. v: velocities after the step in the problem's
/// degrees of freedom. `walls_after`, `cell_after`: the walls and the cell with their velocities
/// after the step.
template <int D>
StepOutcome<D> step_outcome(const Scene<D>& scene, const Midpoint<D>& mid,
                            std::span<const std::type_identity_t<Body<D>>> disks,
                            const AssembledStep& assembled, const Vector& s, const Vector& v,
                            std::span<const std::type_identity_t<Wall<D>>> walls_after,
                            const PeriodicCell& cell_after);

}  // namespace bipot
