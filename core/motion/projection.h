#pragma once

#include <string>

#include "core/motion/time_stepping.h"

namespace bipot {

/// What taking overlaps out of a state did.
struct Projection {
  bool solved = true;    ///< false: bodies stay where they were
  std::string message;   ///< why not
  int iterations = 0;    ///< of the solver
  double wall_work = 0;  ///< of driving forces on the ways of their walls                    [J]
};

/// Moves the bodies of `state`, where some contact overlaps by more than the scene's contact
/// distance, by the smallest displacement in the energy norm, ½ Δqᵀ A Δq, that leaves no overlap:
///
///     0 <= g + Hᵀ Δq  ⟂  λ >= 0,      Δq = A⁻¹ H λ
///
/// with the gaps g and normals of the state, linearised once: what is left is of second order in
/// Δq. Velocities stay as they are. A pair that moves out of its overlap within ten steps
/// by itself, as after an elastic shock, is not pushed; it only must not get deeper. Rotations, walls without a force and periodic cells (refused
/// by validate()) take no part. It is a contact problem without friction in metres instead of m/s,
/// for the step's own solver. Not in the scheme of the paper. [ours]
template <int D>
Projection project_overlaps(const Scene<D>& scene, const StepSolver& solver, bool explicit_delassus,
                            int threads, State<D>& state);

}  // namespace bipot
