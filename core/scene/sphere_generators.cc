#include "core/scene/sphere_generators.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/scene/random_radii.h"

namespace bipot {
std::vector<Sphere> cubic_lattice(int columns, int rows, int layers, double radius,
                                  const Vec3& corner) {
  std::vector<Sphere> spheres;
  spheres.reserve(to_size(columns) * to_size(rows) * to_size(layers));
  for (int k = 0; k < layers; ++k) {
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        const Vec3 at(2 * i + 1, 2 * j + 1, 2 * k + 1);
        spheres.push_back({.x = corner + radius * at, .radius = radius});
      }
    }
  }
  return spheres;
}

std::vector<Sphere> sphere_pyramid(int rows, double radius, const Vec3& corner) {
  const double rise = std::sqrt(2.0);  // of a layer, in radii
  std::vector<Sphere> spheres;
  for (int k = 0; k < rows; ++k) {
    for (int j = 0; j < rows - k; ++j) {
      for (int i = 0; i < rows - k; ++i) {
        const Vec3 at(2 * i + 1 + k, 2 * j + 1 + k, 1 + k * rise);
        spheres.push_back({.x = corner + radius * at, .radius = radius});
      }
    }
  }
  return spheres;
}

std::vector<Sphere> random_spheres(int count, const std::vector<RadiusClass>& classes,
                                   const Vec2& base, double spacing, std::uint64_t seed,
                                   const Vec3& corner, const FillingBounds<3>& bounds) {
  check_filling(count, classes, spacing);
  double largest = 0;
  for (const RadiusClass& c : classes) largest = std::max(largest, c.radius);
  const double pitch = 2 * largest * (1 + spacing);
  const auto cells = [&](double length, const char* what) {
    const double number = std::floor(length / pitch * (1 + 1e-12));
    if (!(number >= 1 && number <= 1e4)) {
      throw std::invalid_argument(
          fmt::format("{} = {} m holds {} spheres of radius {} m side by side, not 1 to 10000",
                      what, length, number, largest));
    }
    return static_cast<int>(number);
  };
  const int columns = cells(base[0], "width"), rows = cells(base[1], "depth");
  const Vec3 cell(base[0] / columns, base[1] / rows, pitch);
  const std::int64_t layer = std::int64_t{columns} * rows;
  PortableRandom random(seed);
  const auto place = [&](std::int64_t k, double radius) {
    const Vec3 number(static_cast<double>(k % columns), static_cast<double>(k / columns % rows),
                      static_cast<double>(k / layer));
    Vec3 x = corner + number.cwiseProduct(cell);
    for (int axis = 0; axis < 3; ++axis) {
      x[axis] += radius + random.uniform() * std::max(cell[axis] - 2 * radius, 0.0);
    }
    return Sphere{.x = x, .radius = radius};
  };
  return whole_filling(count, height_for(count, layer, pitch, bounds), [&](int number) {
    random = PortableRandom(seed);
    return fill_cells<3>(drawn_radii(number, classes, random), layer, pitch, bounds, place);
  });
}

}  // namespace bipot
