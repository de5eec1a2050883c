#include "core/scene/cell.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace bipot {

bool PeriodicCell::deforms() const {
  for (int k = 0; k < 3; ++k) {
    if (side(k).motion != CellSide::Motion::kFixed) return true;
  }
  return false;
}

double stress_force(const PeriodicCell& cell, int side) {
  const CellSide& s = cell.side(side);
  if (s.motion != CellSide::Motion::kDriven) return 0;
  return side == 0   ? -s.stress * cell.height.length
         : side == 1 ? -s.stress * cell.width.length
                     : s.stress * cell.width.length;
}

Vec2 side_share(const PeriodicCell& cell, int side, int kx, int ky) {
  return side == 0 ? Vec2(kx + ky * cell.carried(), 0) : side == 1 ? Vec2(0, ky) : Vec2(ky, 0);
}

void move_cell(PeriodicCell& cell, double dt) {
  cell.offset.length += dt * cell.offset_rate();
  cell.width.length += dt * cell.width.speed;
  cell.height.length += dt * cell.height.speed;
}

double cell_kinetic_energy(const PeriodicCell& cell) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const CellSide& s = cell.side(k);
    if (s.motion == CellSide::Motion::kDriven) sum += 0.5 * s.mass * s.speed * s.speed;
  }
  return sum;
}

CellNumber cell_number(const PeriodicCell& cell, const Vec2& x) {
  CellNumber number;
  if (cell.in_y) number.ky = static_cast<int>(std::floor(x[1] / cell.height.length));
  if (cell.in_x) {
    number.kx =
        static_cast<int>(std::floor((x[0] - number.ky * cell.offset.length) / cell.width.length));
  }
  return number;
}

CellNumber nearest_corner(const PeriodicCell& cell, const Vec2& x) {
  const double ky = cell.in_y ? std::round(x[1] / cell.height.length) : 0;
  const double kx = std::round((x[0] - ky * cell.offset.length) / cell.width.length);
  return {static_cast<int>(kx), static_cast<int>(ky)};
}

Vec2 wrapped(const PeriodicCell& cell, const Vec2& x) {
  const CellNumber number = cell_number(cell, x);
  return x - cell.shift(number.kx, number.ky);
}

std::vector<CellNumber> first_images_over(const PeriodicCell& cell, const Box<2>& contents,
                                          double time, Box<2> box) {
  if (!cell.periodic()) return {{}};  // the sample itself
  const double width = cell.width.length, height = cell.in_y ? cell.height.length : kInfinity;
  const Vec2 farthest = kMostCells * Vec2(width, height);
  box.lower = box.lower.cwiseMax(-farthest);
  box.upper = box.upper.cwiseMin(farthest);
  // Images move with their cells, none that reaches the box faster than this.
  const Vec2 way =
      (box.lower - contents.upper).cwiseAbs().cwiseMax((box.upper - contents.lower).cwiseAbs());
  const double rows = cell.in_y ? way[1] / height + 1 : 0;
  const double columns = (way[0] + rows * std::abs(cell.offset.length)) / width + 1;
  Box<2> reach = contents;
  reach.widen(time * (columns * cell.shift_velocity(1, 0).norm() +
                      rows * cell.shift_velocity(0, 1).norm()));
  const Vec2 low = box.lower - reach.upper, high = box.upper - reach.lower;  // of a shift
  // After one image that reaches the box there is one wholly inside, if the box is longer than the
  // cell and the contents; else there are no more than twice the contents and two.
  const auto last = [](double first, double end, double extents_in_period) {
    return std::min(end, first + 2 + 2 * std::ceil(extents_in_period));
  };
  const double lowest = std::ceil(low[1] / height);
  double highest = std::floor(high[1] / height);
  if (box.size()[0] > width + reach.size()[0]) {  // each row has one
    highest = last(lowest, highest, reach.size()[1] / height);
  }
  std::vector<CellNumber> images;
  for (double ky = lowest; ky <= highest; ++ky) {
    const double aside = ky * cell.offset.length, first = std::ceil((low[0] - aside) / width);
    const double end = last(first, std::floor((high[0] - aside) / width), reach.size()[0] / width);
    for (double kx = first; kx <= end; ++kx) {
      images.push_back({static_cast<int>(kx), static_cast<int>(ky)});
    }
  }
  return images;
}

double shortest_period(const PeriodicCell& cell) {
  double shortest = cell.in_x ? cell.width.length : kInfinity;
  if (!cell.in_y) return shortest;
  const double folded =
      cell.offset.length - std::round(cell.offset.length / cell.width.length) * cell.width.length;
  return std::min(shortest, std::hypot(folded, cell.height.length));
}

Vec2 homogeneous_velocity(const PeriodicCell& cell, const Vec2& x) {
  // x = P f with P = [p_x p_y], so that v = dP/dt f.
  if (!cell.in_x || !cell.deforms()) return Vec2::Zero();
  const double f_y = cell.in_y ? x[1] / cell.height.length : 0;
  const double f_x = (x[0] - f_y * cell.offset.length) / cell.width.length;
  return cell.shift_velocity(f_x, f_y);
}

std::string check_cell(const PeriodicCell& cell) {
  if (!cell.periodic()) return {};
  if (!cell.in_x) return "the cell is periodic in y, but not in x";
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (!positive(cell.width.length) || (cell.in_y && !positive(cell.height.length)) ||
      !std::isfinite(cell.offset.length)) {
    return fmt::format("cell: width = {} m, height = {} m (> 0), offset = {} m", cell.width.length,
                       cell.height.length, cell.offset.length);
  }
  static constexpr const char* kNames[] = {"width", "height", "offset"};
  for (int k = 0; k < 3; ++k) {
    const CellSide& s = cell.side(k);
    const bool driven = s.motion == CellSide::Motion::kDriven;
    if (!std::isfinite(s.speed) || !std::isfinite(s.stress) || (driven && !positive(s.mass))) {
      return fmt::format("cell: {}: speed = {} m/s, stress = {} Pa, mass = {} kg (> 0)", kNames[k],
                         s.speed, s.stress, s.mass);
    }
    if (driven && !cell.in_y) return "cell: a stress needs a cell that is periodic in x and y";
    if (k > 0 && !cell.in_y && (s.motion != CellSide::Motion::kFixed || s.length != 0)) {
      return fmt::format("cell: {} belongs to a cell that is periodic in y", kNames[k]);
    }
  }
  return {};
}

}  // namespace bipot
