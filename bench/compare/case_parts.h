#pragma once

#include <vector>

#include "bench/compare/extreme_case.h"
#include "core/scene/scene_parts.h"

namespace bipot {

/// One material, h = 0.01 s, contacts within 1e-9 m, gravity 9.81 m/s² downwards.
Scene<2> empty_scene(double mu, double e_n = 0, double e_t = 0);
/// The problem of the scene's first step, A and H alone.
ContactProblem first_step(const Scene<2>& scene);
std::function<ContactProblem()> step_of(const Scene<2>& scene);
/// A tower of disks of these masses and radii (bottom first) on a floor, μ = 0.3.
Scene<2> tower(const std::vector<double>& masses, const std::vector<double>& radii);

/// max |x - y| / max |y|.
double relative_difference(const Vector& x, const Vector& y);
/// Impulses of a tower without friction: the contacts carry the weight above, h g Σ m. In the order
/// of the first step's contacts.
Vector tower_impulses(const Scene<2>& scene);
/// The relative difference of the impulses from these.
ExtremeCase::Error against(const Vector& known);
/// Two planes of a wedge open upwards, at this angle from the vertical, touch the scene's disk.
void add_wedge(Scene<2>& scene, double half_angle);
/// Touching disks of 0.5 m and 1 kg in rows, from the origin on.
std::vector<Disk> touching_rows(int columns, int rows);
/// Σ of the normal impulses on that wall.
double push_on_wall(const Scene<2>& scene, std::size_t wall, const Vector& s);

}  // namespace bipot
