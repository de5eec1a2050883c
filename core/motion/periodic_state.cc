#include "core/motion/periodic_state.h"

#include <cmath>

namespace bipot {

template <int D>
State<D> wrapped_state(const State<D>& state) {
  State<D> inside = state;
  const PeriodicCell& cell = state.cell;
  if (!cell.periodic()) return inside;
  const auto move = [&](auto& body, const CellNumber& from) {
    body.x -= in_dimensions<D>(cell.shift(from.kx, from.ky));
    if (cell.deforms()) body.v -= in_dimensions<D>(cell.shift_velocity(from.kx, from.ky));
  };
  // A cluster stays whole: its disks follow its centre of mass.
  std::vector<CellNumber> of_cluster, numbers;
  for (Cluster<D>& c : inside.clusters.bodies) {
    of_cluster.push_back(cell_number(cell, c.x.template head<2>()));
    move(c, of_cluster.back());
  }
  for (Body<D>& d : inside.bodies) {
    numbers.push_back(d.cluster >= 0 ? of_cluster[to_size(d.cluster)]
                                     : cell_number(cell, d.x.template head<2>()));
    move(d, numbers.back());
  }
  for (ContactOutcome<D>& o : inside.contacts) {
    const CellNumber a = numbers[to_size(o.contact.i)];
    const std::size_t j = to_size(o.contact.j);
    const CellNumber b = j < numbers.size() ? numbers[j] : CellNumber{};
    o.contact.image_x += b.kx - a.kx;
    o.contact.image_y += b.ky - a.ky;
  }
  return inside;
}

template <int D>
std::pair<Vec<D>, Vec<D>> drawn_branch(const State<D>& state, const Contact<D>& contact) {
  const Body<D>& i = state.bodies[to_size(contact.i)];
  const std::size_t j = to_size(contact.j);
  if (j >= state.bodies.size()) return {i.x, i.x - i.radius * contact.n};
  Vec<D> other = state.bodies[j].x;
  if (contact.with_image()) {
    other += in_dimensions<D>(state.cell.shift(contact.image_x, contact.image_y));
  }
  return {i.x, other};
}

template State<2> wrapped_state(const State<2>&);
template State<3> wrapped_state(const State<3>&);
template std::pair<Vec2, Vec2> drawn_branch(const State<2>&, const Contact<2>&);
template std::pair<Vec3, Vec3> drawn_branch(const State<3>&, const Contact<3>&);

std::vector<std::pair<Vec2, Vec2>> cell_outline(const PeriodicCell& cell, const Box<2>& box) {
  if (!cell.periodic()) return {};
  const Vec2 p_x = cell.shift(1, 0);
  if (!cell.in_y) {
    const Vec2 low(0, box.lower[1]), high(0, box.upper[1]);
    return {{low, high}, {low + p_x, high + p_x}};
  }
  const Vec2 up(0, cell.height.length), zero = Vec2::Zero();
  return {{zero, p_x}, {p_x, p_x + up}, {p_x + up, up}, {up, zero}};
}

std::vector<std::pair<Vec3, Vec3>> cell_outline(const PeriodicCell& cell, const Box<3>& box) {
  std::vector<std::pair<Vec3, Vec3>> lines;
  if (!cell.periodic()) return lines;
  const double from_y = cell.in_y ? 0 : box.lower[1];
  const double to_y = cell.in_y ? cell.height.length : box.upper[1];
  std::vector<Vec3> faces[2];  // corners around the sides at x = 0 and x = width
  for (const int side : {0, 1}) {
    const double x = side * cell.width.length;
    faces[side] = {Vec3(x, from_y, box.lower[2]), Vec3(x, to_y, box.lower[2]),
                   Vec3(x, to_y, box.upper[2]), Vec3(x, from_y, box.upper[2])};
    for (std::size_t k = 0; k < 4; ++k)
      lines.emplace_back(faces[side][k], faces[side][(k + 1) % 4]);
  }
  if (!cell.in_y) return lines;
  for (std::size_t k = 0; k < 4; ++k) lines.emplace_back(faces[0][k], faces[1][k]);
  return lines;
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

std::vector<CellNumber> images_over(const PeriodicCell& cell, const Box<2>& contents,
                                    const Box<2>& box) {
  std::vector<CellNumber> images = {{}};
  if (!cell.periodic() || contents.empty()) return images;
  const Vec2 low = box.lower - contents.upper, high = box.upper - contents.lower;  // of a shift
  const auto first = [](double at) { return static_cast<int>(std::ceil(at)); };
  const auto last = [](double at) { return static_cast<int>(std::floor(at)); };
  const double height = cell.in_y ? cell.height.length : kInfinity;
  for (int ky = first(low[1] / height); ky <= last(high[1] / height); ++ky) {
    const double aside = ky * cell.offset.length, width = cell.width.length;
    for (int kx = first((low[0] - aside) / width); kx <= last((high[0] - aside) / width); ++kx) {
      if (kx != 0 || ky != 0) images.push_back({kx, ky});
    }
  }
  return images;
}

}  // namespace bipot
