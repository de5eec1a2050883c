#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/scene/scene.h"

namespace bipot {

// Lattices of equal, touching bodies. `corner` is the corner of the bounding box with the smallest
// coordinates; radius in m. Only position and radius are set. Order of disks: row by row from the
// bottom.

/// columns x rows, square lattice.
std::vector<Disk> rectangular_lattice(int columns, int rows, double radius, const Vec2& corner);
/// Triangular lattice: rows of `columns` and `columns - 1` disks alternate.
std::vector<Disk> triangular_lattice(int columns, int rows, double radius, const Vec2& corner);
/// Cannon-ball pyramid: `rows` disks in the lowest row, one at the top.
std::vector<Disk> pyramid(int rows, double radius, const Vec2& corner);

/// A share of disks of one radius.
struct RadiusClass {
  double radius = 0;    ///< [m]
  double fraction = 0;  ///< of the number of disks
};

/// What bounds a random filling besides its base.
template <int D>
struct FillingBounds {
  double height = kInfinity;  ///< above its corner                                      [m]
  /// True if a body with this centre and radius has its place there; empty: everywhere.
  std::function<bool(const Vec<D>&, double)> holds;
};

/// A loose random filling without overlap: `count` disks in the cells of a grid as wide as `width`,
/// from the bottom up, each at a random place of its cell. Class sizes follow the fractions by
/// largest remainders; the sequence of classes is shuffled. `spacing` >= 0 widens the cells beyond
/// the largest diameter, relative. The same bits on every platform: 64-bit Mersenne twister,
/// integer arithmetic and IEEE operations only. Throws std::invalid_argument, also if the bounds do
/// not hold all disks: "fits 180 of 220", with the height that does if bounds are a height alone.
std::vector<Disk> random_filling(int count, const std::vector<RadiusClass>& classes, double width,
                                 double spacing, std::uint64_t seed, const Vec2& corner,
                                 const FillingBounds<2>& bounds = {});

// The same of spheres. Order: along x, then y, then z.

/// columns x rows x layers along x, y and z.
std::vector<Sphere> cubic_lattice(int columns, int rows, int layers, double radius,
                                  const Vec3& corner);
/// Cannon balls: square layers of rows², (rows - 1)², ..., 1, each sphere in the hollow of four.
std::vector<Sphere> sphere_pyramid(int rows, double radius, const Vec3& corner);

/// A loose random filling without overlap, as random_filling(). The cells lie over
/// the rectangle `base` (along x and y) and are filled upwards along z. Throws
/// std::invalid_argument.
std::vector<Sphere> random_spheres(int count, const std::vector<RadiusClass>& classes,
                                   const Vec2& base, double spacing, std::uint64_t seed,
                                   const Vec3& corner, const FillingBounds<3>& bounds = {});

}  // namespace bipot
