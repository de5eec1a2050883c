#include "core/scene/generators.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/scene/random_radii.h"

namespace bipot {
namespace {

/// Rows of which each lies in the hollows of the one before: `before(j)` disks fewer than
/// `columns`, and half a diameter for each of them farther to the right.
template <class Before>
std::vector<Disk> rows_in_hollows(int columns, int rows, double radius, const Vec2& corner,
                                  const Before& before) {
  const double rise = std::sqrt(3.0) * radius;
  std::vector<Disk> disks;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns - before(j); ++i) {
      const double x = corner[0] + (2 * i + 1 + before(j)) * radius;
      disks.push_back({.x = Vec2(x, corner[1] + radius + j * rise), .radius = radius});
    }
  }
  return disks;
}

}  // namespace
std::vector<Disk> rectangular_lattice(int columns, int rows, double radius, const Vec2& corner) {
  std::vector<Disk> disks;
  disks.reserve(to_size(columns) * to_size(rows));
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      disks.push_back(
          {.x = corner + Vec2((2 * i + 1) * radius, (2 * j + 1) * radius), .radius = radius});
    }
  }
  return disks;
}

std::vector<Disk> triangular_lattice(int columns, int rows, double radius, const Vec2& corner) {
  return rows_in_hollows(columns, rows, radius, corner, [](int row) { return row % 2; });
}

std::vector<Disk> pyramid(int rows, double radius, const Vec2& corner) {
  return rows_in_hollows(rows, rows, radius, corner, [](int row) { return row; });
}

std::vector<Disk> random_filling(int count, const std::vector<RadiusClass>& classes, double width,
                                 double spacing, std::uint64_t seed, const Vec2& corner,
                                 const FillingBounds<2>& bounds) {
  check_filling(count, classes, spacing);
  double largest = 0;
  for (const RadiusClass& c : classes) largest = std::max(largest, c.radius);
  const double pitch = 2 * largest * (1 + spacing);
  const double room = std::floor(width / pitch * (1 + 1e-12));
  if (!(room >= 1)) {
    throw std::invalid_argument(
        fmt::format("width = {} m does not hold a disk of radius {} m", width, largest));
  }
  if (!(room <= std::numeric_limits<int>::max())) {
    throw std::invalid_argument(fmt::format(
        "width = {} m holds {:.1e} disks of radius {} m in a row, at most {} are possible", width,
        room, largest, std::numeric_limits<int>::max()));
  }
  const int columns = static_cast<int>(room);
  const double cell_width = width / columns;
  PortableRandom random(seed);
  const auto place = [&](std::int64_t cell, double radius) {
    const auto column = static_cast<double>(cell % columns);
    const auto row = static_cast<double>(cell / columns);
    const double free_x = std::max(cell_width - 2 * radius, 0.0);
    const double free_y = std::max(pitch - 2 * radius, 0.0);
    const double x = corner[0] + column * cell_width + radius + random.uniform() * free_x;
    const double y = corner[1] + row * pitch + radius + random.uniform() * free_y;
    return Disk{.x = Vec2(x, y), .radius = radius};
  };
  return whole_filling(count, height_for(count, columns, pitch, bounds), [&](int number) {
    random = PortableRandom(seed);
    return fill_cells<2>(drawn_radii(number, classes, random), columns, pitch, bounds, place);
  });
}

}  // namespace bipot
