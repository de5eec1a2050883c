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
  int active = 0;                           ///< contacts that push or are held
  double wall_work = 0;                     ///< by walls and sides of a periodic cell     [J]
  double friction_loss = 0;                 ///< dissipated by tangential impulses, moments [J]
  double shock_loss = 0;                    ///< dissipated by normal impulses, but cohesion [J]
  double cohesion_loss = 0;                 ///< taken by cohesion                         [J]
  double joint_loss = 0;                    ///< part of shock_loss: by pins and ropes     [J]
  double from_rest = 0;  ///< with joints: energy that forces alone give bodies at rest    [J]
  Vec<D> external = Vec<D>::Zero();  ///< impulse on disks and driven walls from all else [N s]
};

/// The effects of a step. `disks`: those that contacts may name, for their masses, materials and
/// walls; their positions do not matter. `p`: the problem of `assembled`. s: impulses in its
/// variables. v: velocities after the step in its degrees of freedom. `after`: bodies, walls and
/// cell after the step. `count_walls`: false where another process counts the forces that drive
/// walls.
template <int D>
StepOutcome<D> step_outcome(const Scene<D>& scene, const Midpoint<D>& mid,
                            std::span<const std::type_identity_t<Body<D>>> disks,
                            const ContactProblem& p, const AssembledStep& assembled,
                            const Vector& s, const Vector& v, const State<D>& after,
                            bool count_walls = true);

/// Upper bound of the energy that contacts may exchange in a step h because forces act within it: ½
/// κ |s·f| of data/manual/explanation/method.md §3 with κ <= 1. f = h g at walls, besides h times
/// the acceleration of driven ones, that of driven sides of the cell at images, and 0 between other
/// bodies, which fall alike. `bodies`: from this number on j is a wall.                [J]
template <int D>
double force_energy(const Vec<D>& gravity, const std::vector<Wall<D>>& walls,
                    const PeriodicCell& cell, double h,
                    const std::vector<ContactOutcome<D>>& contacts, std::size_t bodies) {
  double of_cell = 0;
  for (int k = 0; k < 3; ++k) {
    if (cell.side(k).motion != CellSide::Motion::kDriven) continue;
    of_cell += std::abs(stress_force(cell, k)) / cell.side(k).mass;
  }
  double energy = 0;
  for (const ContactOutcome<D>& c : contacts) {
    const std::size_t j = to_size(c.contact.j);
    double acceleration = c.contact.with_image() ? of_cell : 0;
    if (j >= bodies) {
      const Wall<D>& wall = walls[j - bodies];
      const bool driven = wall.motion == Wall<D>::Motion::kDriven;
      acceleration += gravity.norm() + (driven ? std::abs(wall.force) / wall.mass : 0);
    }
    energy += 0.5 * h * acceleration * std::hypot(c.s_n, magnitude(c.s_t));
  }
  return energy;
}

}  // namespace bipot
