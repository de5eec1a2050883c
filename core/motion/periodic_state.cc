#include "core/motion/periodic_state.h"

#include <cmath>

namespace bipot {

State wrapped_state(const State& state) {
  State inside = state;
  const PeriodicCell& cell = state.cell;
  if (!cell.periodic()) return inside;
  std::vector<CellNumber> numbers;
  for (Disk& d : inside.disks) {
    numbers.push_back(cell_number(cell, d.x));
    d.x -= cell.shift(numbers.back().kx, numbers.back().ky);
    if (cell.deforms()) d.v -= cell.shift_velocity(numbers.back().kx, numbers.back().ky);
  }
  for (ContactOutcome& o : inside.contacts) {
    const CellNumber a = numbers[to_size(o.contact.i)];
    const std::size_t j = to_size(o.contact.j);
    const CellNumber b = j < numbers.size() ? numbers[j] : CellNumber{};
    o.contact.image_x += b.kx - a.kx;
    o.contact.image_y += b.ky - a.ky;
  }
  return inside;
}

std::pair<Vec2, Vec2> drawn_branch(const State& state, const Contact& contact) {
  const Disk& i = state.disks[to_size(contact.i)];
  const std::size_t j = to_size(contact.j);
  if (j >= state.disks.size()) return {i.x, i.x - i.radius * contact.n};
  Vec2 other = state.disks[j].x;
  if (contact.with_image()) other += state.cell.shift(contact.image_x, contact.image_y);
  return {i.x, other};
}

std::vector<std::pair<Vec2, Vec2>> cell_outline(const PeriodicCell& cell, const Box& box) {
  if (!cell.periodic()) return {};
  const Vec2 p_x = cell.shift(1, 0);
  if (!cell.in_y) {
    const Vec2 low(0, box.lower[1]), high(0, box.upper[1]);
    return {{low, high}, {low + p_x, high + p_x}};
  }
  const Vec2 up(0, cell.height.length), zero = Vec2::Zero();
  return {{zero, p_x}, {p_x, p_x + up}, {p_x + up, up}, {up, zero}};
}

std::vector<Vec2> image_shifts(const PeriodicCell& cell) {
  std::vector<Vec2> shifts = {Vec2::Zero()};
  if (!cell.periodic()) return shifts;
  for (int ky = cell.in_y ? -1 : 0; ky <= (cell.in_y ? 1 : 0); ++ky) {
    // The rows above and below are shifted by the offset, less whole widths.
    const int whole = static_cast<int>(std::lround(ky * cell.offset.length / cell.width.length));
    for (int kx = -whole - 1; kx <= -whole + 1; ++kx) {
      if (kx != 0 || ky != 0) shifts.push_back(cell.shift(kx, ky));
    }
  }
  return shifts;
}

}  // namespace bipot
