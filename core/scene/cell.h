#pragma once

#include <string>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// One of the three numbers that shape a periodic cell. It is fixed, changes at a given speed, or
/// is driven by a stress on a mass of its own, like a driven wall.
struct CellSide {
  enum class Motion { kFixed, kMoving, kDriven };
  Motion motion = Motion::kFixed;
  double length = 0;  ///< [m]
  double speed = 0;   ///< of the length; of the offset without what the width carries     [m/s]
  double stress = 0;  ///< driven: pressure (width, height) or shear stress (offset)       [Pa]
  double mass = 0;    ///< driven: > 0; energy is 1/2 mass speed²                          [kg]

  bool operator==(const CellSide&) const = default;
};

/// A periodic scene repeats itself by p_x = (width, 0) and p_y = (offset, height). Image (kx, ky)
/// of a body lies at x + kx p_x + ky p_y and moves with v + kx dp_x/dt + ky dp_y/dt. The second
/// part is the velocity jump across the cell. Coordinates of bodies are not wrapped: a body that
/// leaves the cell keeps its coordinates, and its cell is computed where it is needed.
///
/// A driven width stretches the whole lattice along x, so it carries the offset along. With h =
/// [p_x p_y] and L = dh/dt h⁻¹ the speeds of the sides are then width L_xx, height L_yy and height
/// L_xy. As area σ:L is the power of the contacts, their conjugate forces are height σ_xx, width
/// σ_yy and width σ_xy. At a given offset that of the width would be height σ_xx - offset σ_xy, with
/// a σ_xy that may be a reaction. [ours]
struct PeriodicCell {
  bool in_x = false, in_y = false;  ///< in_y only together with in_x
  CellSide width, height, offset;

  bool operator==(const PeriodicCell&) const = default;
  bool periodic() const { return in_x || in_y; }
  /// True if a side moves or may move: images then have velocities.
  bool deforms() const;
  Vec2 shift(int kx, int ky) const {
    return Vec2(kx * width.length + ky * offset.length, ky * height.length);
  }
  /// What a growing width carries the offset along. [m/m]
  double carried() const {
    return width.motion == CellSide::Motion::kDriven ? offset.length / width.length : 0;
  }
  /// d offset/dt. [m/s]
  double offset_rate() const { return offset.speed + carried() * width.speed; }
  Vec2 shift_velocity(double kx, double ky) const {
    return Vec2(kx * width.speed + ky * offset_rate(), ky * height.speed);
  }
  CellSide& side(int k) { return k == 0 ? width : k == 1 ? height : offset; }
  const CellSide& side(int k) const { return k == 0 ? width : k == 1 ? height : offset; }
};

/// A shift or velocity of an image; in 3D its third component is 0.
template <int D>
Vec<D> in_dimensions(const Vec2& x) {
  Vec<D> y = Vec<D>::Zero();
  y.template head<2>() = x;
  return y;
}

/// Generalised force of the stress on the three sides: -p_x height, -p_y width, shear width. [N]
double stress_force(const PeriodicCell& cell, int side);

/// Derivative of the velocity of image (kx, ky) with respect to the speed of a side.
Vec2 side_share(const PeriodicCell& cell, int side, int kx, int ky);

/// Moves each side by dt times its rate.
void move_cell(PeriodicCell& cell, double dt);

/// 1/2 Σ mass speed² of driven sides.                                                      [J]
double cell_kinetic_energy(const PeriodicCell& cell);

/// Indices of the cell that contains x: x - shift(kx, ky) is in [0, width) x [0, height). Zero in
/// directions that are not periodic.
struct CellNumber {
  int kx = 0, ky = 0;
};
CellNumber cell_number(const PeriodicCell& cell, const Vec2& x);
/// Those of the cell whose corner is nearest to x.
CellNumber nearest_corner(const PeriodicCell& cell, const Vec2& x);
/// The image of x in the cell (0, 0).
Vec2 wrapped(const PeriodicCell& cell, const Vec2& x);

/// Velocity of the cell that contains x against the cell (0, 0). [m/s]
template <int D>
Vec<D> image_velocity(const PeriodicCell& cell, const Vec<D>& x) {
  if (!cell.deforms()) return Vec<D>::Zero();
  const CellNumber k = cell_number(cell, x.template head<2>());
  return in_dimensions<D>(cell.shift_velocity(k.kx, k.ky));
}

/// Images that, moved by their cells for up to that time, may reach the box within kMostCells.
/// Of a box longer than the cell only some are listed: if any image reaches it, one of them does.
std::vector<CellNumber> first_images_over(const PeriodicCell& cell, const Box<2>& contents,
                                          double time, Box<2> box);
inline constexpr double kMostCells = 1000;

/// Length of the shortest way from a body to an image of itself. [m]
double shortest_period(const PeriodicCell& cell);

/// Velocity of the homogeneous deformation at x; zero if the cell does not move. [m/s]
Vec2 homogeneous_velocity(const PeriodicCell& cell, const Vec2& x);

/// Empty for a sound cell, else an error message with the values.
std::string check_cell(const PeriodicCell& cell);

}  // namespace bipot
