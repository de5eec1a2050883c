#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/interrupt.h"
#include "core/scene/scene.h"
#include "core/scene/scene_family.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {

/// Scenes that move, of one shape and any size. side² disks of three radii (0.4, 0.5, 0.6 m, a
/// third each) and 1000 kg/m² are loose above the floor, drawn by the seed; gravity 9.81 m/s².
///   "pour":     they fall into a box as wide as `side` disks
///   "collapse": a narrow column of them (0.63 `side` wide) falls on a floor without walls, and
///               spreads
///   "tilt":     as pour, with gravity turned by the tilt (30 degrees by default)
///   "strike":   as pour, and a disk of radius side/16 m and 5000 kg/m² falls after them at
///               60 sqrt(side/32) m/s
/// h = 0.005 s (strike: 0.002 s). The number of steps grows with sqrt(side) and covers the motion
/// until nearly all are at rest: 600 (pour), 900, 700, 1500 for a side of 32. The option mass_ratio
/// is ignored. Throws std::invalid_argument for another name.
Scene<2> make_moving_scene(const std::string& family, int side, const FamilyOptions& options);
std::vector<std::string> moving_family_names();

/// Scenes of spheres that move, of one shape and any size. side³ spheres of three radii (0.4, 0.5,
/// 0.6 m, a third each) and 1000 kg/m³ are loose above the floor, drawn by the seed; gravity 9.81
/// m/s², h = 0.005 s.
///   "pour3d":  they fall into a box, `side` m wide and deep
///   "pipe":    they fall into a vertical pipe about such a box
///   "shear3d": as pour3d, periodic along x, on a floor whose surface moves along x at side/4 m/s
/// The number of steps grows with sqrt(side): 350, 350 and 500 for a side of 8. The options
/// mass_ratio and tilt_degrees (gravity, towards x) are as above. Throws std::invalid_argument for
/// another name.
Scene<3> make_moving_spheres(const std::string& family, int side, const FamilyOptions& options);
std::vector<std::string> moving_sphere_names();

/// Runs a moving scene up to the last of `steps`, increasing from 1. The solver is `apgd` to 1e-2
/// with at most kMovingIterations in each step, warm started. This is fixed, so that the problems
/// do not depend on changes of other solvers. `on_step` receives those of `steps` that have
/// contacts. Throws StepFailure, and Interrupted once `cancelled` is true.
template <int D>
void run_moving_scene(const Scene<D>& scene, const std::vector<int>& steps,
                      const std::function<void(const SceneStep<D>&)>& on_step,
                      const std::function<bool()>& cancelled = &InterruptGuard::requested);

inline constexpr double kMovingTolerance = 1e-2;
inline constexpr int kMovingIterations = 1000;

}  // namespace bipot
