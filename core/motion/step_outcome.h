#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/motion/midpoint.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// What an impulse says of its contact; s_t in the plane with its sign, in space its magnitude. The
/// cone's edge counts from kConeEdge on.
ContactStatus contact_status(double s_n, double s_t, double mu);

/// What the impulses of a nonsmooth step did. Powers are those of the mean of the velocities before
/// and after the step, as the displacement is.
template <int D>
struct StepOutcome {
  std::vector<ContactOutcome<D>> contacts;  ///< one for each candidate, in their order
  int active = 0;                           ///< contacts with s_n > 0
  double wall_work = 0;                     ///< by walls and sides of a periodic cell     [J]
  double friction_loss = 0;                 ///< dissipated by tangential impulses         [J]
  double shock_loss = 0;                    ///< dissipated by normal impulses             [J]
  Vec<D> external = Vec<D>::Zero();  ///< impulse on disks and driven walls from all else [N s]
};

/// What contacts did alone, without gravity and driving forces. Arguments as of step_outcome(); of
/// problems that lie on several processes each has its contacts (solvers/domains).
template <int D>
StepOutcome<D> contact_outcomes(const Scene<D>& scene, const Midpoint<D>& mid,
                                std::span<const std::type_identity_t<Body<D>>> disks,
                                const AssembledStep& assembled, const Vector& s, const Vector& v);

/// The forces that drive these walls, as they are in the step and after it, over its length.
template <int D>
void add_driving_forces(double step, std::span<const std::type_identity_t<Wall<D>>> walls,
                        std::span<const std::type_identity_t<Wall<D>>> walls_after,
                        StepOutcome<D>& outcome);

/// `disks`: those of the step, for their masses, materials and walls (where they are does not matter);
/// s: impulses in the problem's variables; v: velocities after the step in the problem's degrees of
/// freedom; `walls_after`, `cell_after`: the walls and the cell with their velocities after the step.
template <int D>
StepOutcome<D> step_outcome(const Scene<D>& scene, const Midpoint<D>& mid,
                            std::span<const std::type_identity_t<Body<D>>> disks,
                            const AssembledStep& assembled, const Vector& s, const Vector& v,
                            std::span<const std::type_identity_t<Wall<D>>> walls_after,
                            const PeriodicCell& cell_after);

}  // namespace bipot
