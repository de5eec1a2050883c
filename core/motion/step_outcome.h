#pragma once

#include <span>
#include <vector>

#include "core/motion/midpoint.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// What an impulse says of its contact. The cone's edge counts from kConeEdge on.
ContactStatus contact_status(double s_n, double s_t, double mu);

/// What the impulses of a nonsmooth step did. Powers are those of the mean of the velocities before
/// and after the step, as the displacement is.
struct StepOutcome {
  std::vector<ContactOutcome> contacts;  ///< one for each candidate, in their order
  int active = 0;                        ///< contacts with s_n > 0
  double wall_work = 0;                  ///< by moving and driven walls                     [J]
  double friction_loss = 0;              ///< dissipated by tangential impulses              [J]
  double shock_loss = 0;                 ///< dissipated by normal impulses                  [J]
  Vec2 external = Vec2::Zero();  ///< impulse on disks and driven walls from all else        [N s]
};

/// s: impulses in the problem's variables; v: velocities after the step in the problem's degrees of
/// freedom; `walls_after`: the walls with their velocities after the step.
StepOutcome step_outcome(const Scene& scene, const Midpoint& mid, const AssembledStep& assembled,
                         const Vector& s, const Vector& v, std::span<const Wall> walls_after);

}  // namespace bipot
