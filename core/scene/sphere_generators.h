#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/generators.h"
#include "core/scene/scene.h"

namespace bipot {

/// Lattices of equal, touching spheres. `corner` is the corner of the bounding box with the
/// smallest coordinates; radius in m. Only position and radius are set. Order: along x, then y,
/// then z.

/// columns x rows x layers along x, y and z.
std::vector<Sphere> cubic_lattice(int columns, int rows, int layers, double radius,
                                  const Vec3& corner);
/// Cannon balls: square layers of rows², (rows - 1)², ..., 1, each sphere in the hollow of four.
std::vector<Sphere> sphere_pyramid(int rows, double radius, const Vec3& corner);

/// A loose random filling without overlap, as random_filling() of generators.h. The cells lie over
/// the rectangle `base` (along x and y) and are filled upwards along z. Throws
/// std::invalid_argument.
std::vector<Sphere> random_spheres(int count, const std::vector<RadiusClass>& classes,
                                   const Vec2& base, double spacing, std::uint64_t seed,
                                   const Vec3& corner, const FillingBounds<3>& bounds = {});

}  // namespace bipot
