#pragma once

#include <string>
#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Three-dimensional problems for solvers and tests: one step h = 0.01 s from rest of equal spheres
/// (radius 0.5 m, mass 1 kg, inertia 2/5 m a², 9.81 m/s², no restitution), in global form. A sphere
/// has six degrees of freedom (velocity, then spin). Local frames are (n, t, s) with n from the
/// other body. Gravity is tilted by `tilt_degrees` towards +x.

/// Cannon balls: square layers of layers², (layers - 1)², ..., 1 spheres on a floor, each in the
/// hollow of four below.
ContactProblem sphere_pyramid(int layers, double mu, double tilt_degrees);

/// side³ spheres in a cubic lattice between a floor and four walls.
ContactProblem sphere_box(int side, double mu, double tilt_degrees);

/// The two by name, "cannonballs" and "cubic", with `side` layers or spheres along a side. Throws
/// std::invalid_argument for another name.
ContactProblem sphere_family(const std::string& name, int side, double mu, double tilt_degrees);
std::vector<std::string> sphere_family_names();
/// Number of spheres.
double spheres_in(const std::string& family, int side);

}  // namespace bipot
