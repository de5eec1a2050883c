#pragma once

#include <vector>

#include "core/problem/contact_problem.h"
#include "core/scene/scene_parts.h"

namespace bipot {

/// One material, h = 0.01 s, contacts within 1e-9 m, gravity 9.81 m/s² downwards.
Scene<2> empty_scene(double mu, double e_n = 0, double e_t = 0);
/// The problem of the scene's first step, A and H alone.
ContactProblem first_step(const Scene<2>& scene);
/// A tower of disks of these masses and radii (bottom first) on a floor.
Scene<2> tower(const std::vector<double>& masses, const std::vector<double>& radii,
               double mu = 0.3);

/// max |x - y| / max |y|.
double relative_difference(const Vector& x, const Vector& y);
/// Impulses of a tower without friction: the contacts carry the weight above, h g Σ m. In the order
/// of the first step's contacts.
Vector tower_impulses(const Scene<2>& scene);
/// max |u| / (h g): remaining motion of a scene that can be at rest.
double motion_left(const Scene<2>& scene, const Vector& u);
/// Σ of the normal impulses on that wall.
double push_on_wall(const Scene<2>& scene, std::size_t wall, const Vector& s);

}  // namespace bipot
