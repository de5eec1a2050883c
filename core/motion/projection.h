#pragma once

#include <string>

#include "core/motion/time_stepping.h"

namespace bipot {

/// Result of a projection.
struct Projection {
  bool solved = true;    ///< false: bodies stay where they were
  std::string message;   ///< why not
  int iterations = 0;    ///< of the solver
  double wall_work = 0;  ///< of driving forces on the ways of their walls                    [J]
};

/// Removes overlaps: moves the bodies of `state` if some contact overlaps by more than the scene's
/// contact distance. The displacement is the smallest one in the energy norm, ½ Δqᵀ A Δq:
///
///     0 <= g + Hᵀ Δq  ⟂  λ >= 0,      Δq = A⁻¹ H λ
///
/// with the gaps g and normals of the state, linearised once: an overlap of second order in Δq
/// remains. Velocities do not change. A pair that leaves its overlap within ten steps by itself, as
/// after an elastic shock, is not pushed; it only must not get deeper. Rotations and undriven walls
/// do not move. Periodic cells are refused by validate().
///
/// It is a contact problem without friction in metres instead of m/s, for the solver of the step.
/// With a `reach` > 0 [m], pairs up to it apart stay clear of each other as well, and an overlap gets
/// smaller by it at most. Not in the scheme of the paper. [ours]
template <int D>
Projection project_overlaps(const Scene<D>& scene, const StepSolver& solver, int threads,
                            State<D>& state, double reach = 0);

}  // namespace bipot
