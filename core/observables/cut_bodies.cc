#include "core/observables/cut_bodies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace bipot {
namespace {

constexpr double kPi = std::numbers::pi;

/// Area of the unit disk with X > x.
double cap(double x) {
  x = std::clamp(x, -1.0, 1.0);
  return std::acos(x) - x * std::sqrt(1 - x * x);
}

/// Area of the unit disk with X < x and Y < y.
double corner(double x, double y) {
  x = std::clamp(x, -1.0, 1.0);
  y = std::clamp(y, -1.0, 1.0);
  if (x * x + y * y >= 1) {  // the corner lies outside of the disk
    if (x < 0 && y < 0) return 0;
    if (x >= 0 && y >= 0) return kPi - cap(x) - cap(y);
    return x < 0 ? cap(-x) : cap(-y);
  }
  // Between the chord at Y = y and the lower half, from the left end of the chord on.
  const double end = std::sqrt(1 - y * y);
  const auto primitive = [](double t) { return 0.5 * (t * std::sqrt(1 - t * t) + std::asin(t)); };
  const double between = y * (x + end) + primitive(x) - primitive(-end);
  return y >= 0 ? cap(end) + between : between;
}

double safe_acos(double x) { return std::acos(std::clamp(x, -1.0, 1.0)); }

/// Angle by which the boundary turns where the circles X = x and Y = y of the unit sphere meet.
double turn_at(double x, double y) {
  return safe_acos(-x * y / std::sqrt((1 - x * x) * (1 - y * y)));
}

// The parts of the unit ball beyond one, two and three planes are cones from the centre over a part
// of the sphere, less cones over plane sections: V = (S - Σ x A_x)/3. By Gauss and Bonnet, S is 2π
// less the turning of its boundary. That is x times the angle of the arc on the circle X = x, plus
// the angles at its corners. The part beyond a plane with x < 0 is the ball less the mirror image
// of that beyond -x.

/// Volume of the unit ball with X > x.
double beyond(double x) {
  x = std::clamp(x, -1.0, 1.0);
  return kPi / 3 * (1 - x) * (1 - x) * (2 + x);
}

/// Volume of the unit ball with X > x and Y > y.
double beyond(double x, double y) {
  if (x < 0) return beyond(y) - beyond(-x, y);
  if (y < 0) return beyond(x) - beyond(x, -y);
  if (x * x + y * y >= 1) return 0;
  const double at_x = std::sqrt(1 - x * x), at_y = std::sqrt(1 - y * y);
  const double surface =
      2 * (kPi - x * safe_acos(y / at_x) - y * safe_acos(x / at_y) - turn_at(x, y));
  return (surface - x * at_x * at_x * cap(y / at_x) - y * at_y * at_y * cap(x / at_y)) / 3;
}

/// Volume of the unit ball with X > x, Y > y and Z > z.
double beyond(double x, double y, double z) {
  if (x < 0) return beyond(y, z) - beyond(-x, y, z);
  if (y < 0) return beyond(x, z) - beyond(x, -y, z);
  if (z < 0) return beyond(x, y) - beyond(x, y, -z);
  if (x * x + y * y + z * z >= 1) return 0;
  double surface = 2 * kPi - turn_at(x, y) - turn_at(y, z) - turn_at(z, x), sections = 0;
  for (const auto& [a, b, c] : {std::array{x, y, z}, {y, z, x}, {z, x, y}}) {
    const double at = std::sqrt(1 - a * a);
    surface -= a * (safe_acos(b / at) - std::asin(std::min(1.0, c / at)));
    sections += a * at * at * corner(-b / at, -c / at);
  }
  return (surface - sections) / 3;
}

}  // namespace

double part_in_box(const Vec2& x, double radius, const Box<2>& box) {
  const Vec2 a = (box.lower - x) / radius, b = (box.upper - x) / radius;
  const double unit =
      corner(b[0], b[1]) - corner(a[0], b[1]) - corner(b[0], a[1]) + corner(a[0], a[1]);
  return radius * radius * std::max(0.0, unit);
}

double area_in_disk(double distance, double radius, double other_radius) {
  const double d = std::abs(distance), a = std::min(radius, other_radius),
               b = std::max(radius, other_radius);
  if (d >= a + b) return 0;
  if (d <= b - a) return kPi * a * a;
  // The common chord lies at x from the centre of the smaller disk, towards the other: two caps.
  const double x = (d * d + a * a - b * b) / (2 * d);
  return a * a * cap(x / a) + b * b * cap((d - x) / b);
}

double part_in_box(const Vec3& x, double radius, const Box<3>& box) {
  const Vec3 a = ((box.lower - x) / radius).cwiseMax(-1).cwiseMin(1);
  const Vec3 b = ((box.upper - x) / radius).cwiseMax(-1).cwiseMin(1);
  if (!(a.array() < b.array()).all()) return 0;
  double unit = 0;
  for (int which = 0; which < 8; ++which) {
    const auto end = [&](int axis) { return (which >> axis & 1) != 0 ? b[axis] : a[axis]; };
    const bool odd = ((which & 1) + (which >> 1 & 1) + (which >> 2 & 1)) % 2 != 0;
    unit += (odd ? -1 : 1) * beyond(end(0), end(1), end(2));
  }
  return radius * radius * radius * std::max(0.0, unit);
}

}  // namespace bipot
