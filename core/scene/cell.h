#pragma once

#include <string>

#include "core/base/types.h"

namespace bipot {

/// One of the three numbers that shape a cell: it stays, changes with a given speed, or is driven
/// by a stress on a mass of its own, as a driven wall is.
struct CellSide {
  enum class Motion { kFixed, kMoving, kDriven };
  Motion motion = Motion::kFixed;
  double length = 0;  ///< [m]
  double speed = 0;   ///< of the length                                                   [m/s]
  double stress = 0;  ///< driven: pressure (width, height) or shear stress (offset)       [Pa]
  double mass = 0;    ///< driven: > 0; energy is 1/2 mass speed²                          [kg]
};

/// A periodic scene repeats itself by p_x = (width, 0) and p_y = (offset, height). Bodies keep the
/// coordinates that they have come to: their cell is found where it is needed, and nothing jumps
/// when one leaves it. Image (kx, ky) of a body lies at x + kx p_x + ky p_y and moves with
/// v + kx dp_x/dt + ky dp_y/dt: the velocity jump across the cell.
struct PeriodicCell {
  bool in_x = false, in_y = false;  ///< in_y only together with in_x
  CellSide width, height, offset;

  bool periodic() const { return in_x || in_y; }
  /// True where a side moves or may move: images then have velocities.
  bool deforms() const;
  Vec2 shift(int kx, int ky) const {
    return Vec2(kx * width.length + ky * offset.length, ky * height.length);
  }
  Vec2 shift_velocity(int kx, int ky) const {
    return Vec2(kx * width.speed + ky * offset.speed, ky * height.speed);
  }
  CellSide& side(int k) { return k == 0 ? width : k == 1 ? height : offset; }
  const CellSide& side(int k) const { return k == 0 ? width : k == 1 ? height : offset; }
};

/// A shift or velocity of an image; in space its third component is 0.
template <int D>
Vec<D> in_dimensions(const Vec2& x) {
  Vec<D> y = Vec<D>::Zero();
  y.template head<2>() = x;
  return y;
}

/// Generalised force of the stress on the three sides: -p_x height, -p_y width, shear width [N].
double stress_force(const PeriodicCell& cell, int side);

/// How much the velocity of image (kx, ky) along the axis changes with the speed of a side.
double side_share(int side, int kx, int ky, const Vec2& axis);

/// Every length by dt with its speed.
void move_cell(PeriodicCell& cell, double dt);

/// 1/2 Σ mass speed² of driven sides.                                                      [J]
double cell_kinetic_energy(const PeriodicCell& cell);

/// Numbers of the cell that x lies in: x - shift(kx, ky) is in [0, width) x [0, height). 0 in
/// directions that are not periodic.
struct CellNumber {
  int kx = 0, ky = 0;
};
CellNumber cell_number(const PeriodicCell& cell, const Vec2& x);
/// x in the cell (0, 0).
Vec2 wrapped(const PeriodicCell& cell, const Vec2& x);

/// Length of the shortest way from a body to an image of itself.                           [m]
double shortest_period(const PeriodicCell& cell);

/// Velocity of the homogeneous deformation at x; zero where the cell does not move.        [m/s]
Vec2 homogeneous_velocity(const PeriodicCell& cell, const Vec2& x);

/// Empty for a sound cell, else what is wrong, with the values.
std::string check_cell(const PeriodicCell& cell);

}  // namespace bipot
