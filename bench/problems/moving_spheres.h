#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.h"
#include "core/scene/scene_family.h"

namespace bipot {

/// Scenes of spheres that move, of one shape and any size. side³ spheres of three radii (0.4, 0.5,
/// 0.6 m, a third each) and 1000 kg/m³ are loose above the floor, drawn by the seed; gravity 9.81
/// m/s², h = 0.005 s.
///   "pour3d":  they fall into a box, `side` m wide and deep
///   "pipe":    they fall into a vertical pipe about such a box
///   "shear3d": as pour3d, periodic along x, on a floor whose surface moves along x at side/4 m/s
/// The number of steps grows with sqrt(side): 350, 350 and 500 for a side of 8. The options
/// mass_ratio and tilt_degrees (gravity, towards x) are as for moving_scene.h. Throws
/// std::invalid_argument for another name.
Scene<3> make_moving_spheres(const std::string& family, int side, const FamilyOptions& options);
std::vector<std::string> moving_sphere_names();

}  // namespace bipot
