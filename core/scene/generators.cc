#include "core/scene/generators.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/base/portable_random.h"

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

/// The largest radius of the classes. Throws std::invalid_argument for a count, classes or a spacing
/// that no filling can have.
double largest_radius(int count, const std::vector<RadiusClass>& classes, double spacing) {
  if (count < 0) throw std::invalid_argument(fmt::format("count = {} is negative", count));
  if (classes.empty()) throw std::invalid_argument("no radius classes");
  if (!(spacing >= 0)) {
    throw std::invalid_argument(fmt::format("spacing = {} is not >= 0", spacing));
  }
  double largest = 0;
  for (const RadiusClass& c : classes) largest = std::max(largest, c.radius);
  return largest;
}

/// Throws std::invalid_argument: so many bodies have a place, fewer than asked for. `height` would
/// hold all, in m; infinite: unknown.
[[noreturn]] void refuse_filling(int fits, int asked, double height) {
  std::string message =
      fmt::format("fits {} of {}: make its room larger, or the bodies fewer", fits, asked);
  if (std::isfinite(height)) {
    const double step = std::pow(10.0, std::floor(std::log10(height)) - 3);
    message += fmt::format("; height = {:g} holds all", std::ceil(height / step) * step);
  }
  throw std::invalid_argument(message);
}

/// `count` radii in random order, whose numbers per class follow by largest remainders. Throws
/// std::invalid_argument for classes without sound radii and shares.
std::vector<double> drawn_radii(int count, const std::vector<RadiusClass>& classes,
                                PortableRandom& random) {
  double total = 0;
  for (const RadiusClass& c : classes) {
    if (!(c.radius > 0) || !(c.fraction >= 0)) {
      throw std::invalid_argument(fmt::format(
          "radius class: radius = {} (> 0), fraction = {} (>= 0)", c.radius, c.fraction));
    }
    total += c.fraction;
  }
  if (!(total > 0)) throw std::invalid_argument("the fractions of the radius classes add up to 0");
  std::vector<int> sizes;
  std::vector<double> remainders;
  for (const RadiusClass& c : classes) {
    const double share = count * c.fraction / total;
    sizes.push_back(static_cast<int>(std::floor(share)));
    remainders.push_back(share - sizes.back());
  }
  std::vector<int> order(classes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return remainders[to_size(a)] > remainders[to_size(b)]; });
  int missing = count - std::accumulate(sizes.begin(), sizes.end(), 0);
  for (std::size_t k = 0; missing > 0; k = (k + 1) % order.size(), --missing) {
    ++sizes[to_size(order[k])];
  }
  std::vector<double> radii;
  for (std::size_t k = 0; k < classes.size(); ++k) {
    radii.insert(radii.end(), to_size(sizes[k]), classes[k].radius);
  }
  for (std::size_t i = radii.size(); i > 1; --i) std::swap(radii[i - 1], radii[random.below(i)]);
  return radii;
}

/// One body for each radius, in cells from the bottom up. `place(cell, radius)` draws one in a cell,
/// and `layer` is the number of cells with the same height, `pitch` apart. A cell in which the
/// bounds hold none of several draws stays empty. Fewer where the bounds end.
template <int D, class Place>
std::vector<Body<D>> fill_cells(const std::vector<double>& radii, std::int64_t layer, double pitch,
                                const FillingBounds<D>& bounds, const Place& place) {
  constexpr int kDraws = 20;
  constexpr std::int64_t kMostEmpty = 1000000;  // in a row: there is no more room
  const double layers = std::floor(bounds.height / pitch * (1 + 1e-12));
  std::vector<Body<D>> bodies;
  bodies.reserve(radii.size());
  std::int64_t cell = 0, empty = 0;
  while (bodies.size() < radii.size()) {
    const double radius = radii[bodies.size()];
    if (static_cast<double>(cell / layer) >= layers || empty > kMostEmpty) break;
    bool held = false;
    for (int draw = 0; draw < kDraws && !held; ++draw) {
      const Body<D> body = place(cell, radius);
      held = !bounds.holds || bounds.holds(body.x, radius);
      if (held) bodies.push_back(body);
    }
    empty = held ? 0 : empty + 1;
    ++cell;
  }
  return bodies;
}

/// `count` bodies in cells, as fill_cells() has them; `place(cell, radius, random)`. Throws
/// std::invalid_argument where not all have a place, with a number for which all have one.
template <int D, class Place>
std::vector<Body<D>> filling(int count, const std::vector<RadiusClass>& classes, std::uint64_t seed,
                             std::int64_t layer, double pitch, const FillingBounds<D>& bounds,
                             const Place& place) {
  const auto fill = [&](int number) {
    PortableRandom random(seed);
    const std::vector<double> radii = drawn_radii(number, classes, random);
    return fill_cells<D>(radii, layer, pitch, bounds, [&](std::int64_t cell, double radius) {
      return place(cell, radius, random);
    });
  };
  std::vector<Body<D>> bodies = fill(count);
  int fits = static_cast<int>(bodies.size());
  if (fits == count) return bodies;
  // Fewer bodies have other sizes.
  for (int made = fits; (made = static_cast<int>(fill(fits).size())) < fits;) fits = made;
  // With walls cells may stay empty.
  const auto layers = static_cast<double>((count + layer - 1) / layer);
  refuse_filling(fits, count, bounds.holds ? kInfinity : pitch * layers);
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
  const double largest = largest_radius(count, classes, spacing);
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
  const auto place = [&](std::int64_t cell, double radius, PortableRandom& random) {
    const auto column = static_cast<double>(cell % columns);
    const auto row = static_cast<double>(cell / columns);
    const double free_x = std::max(cell_width - 2 * radius, 0.0);
    const double free_y = std::max(pitch - 2 * radius, 0.0);
    const double x = corner[0] + column * cell_width + radius + random.uniform() * free_x;
    const double y = corner[1] + row * pitch + radius + random.uniform() * free_y;
    return Disk{.x = Vec2(x, y), .radius = radius};
  };
  return filling<2>(count, classes, seed, columns, pitch, bounds, place);
}

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
  const double largest = largest_radius(count, classes, spacing);
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
  const auto place = [&](std::int64_t k, double radius, PortableRandom& random) {
    const Vec3 number(static_cast<double>(k % columns), static_cast<double>(k / columns % rows),
                      static_cast<double>(k / layer));
    Vec3 x = corner + number.cwiseProduct(cell);
    for (int axis = 0; axis < 3; ++axis) {
      x[axis] += radius + random.uniform() * std::max(cell[axis] - 2 * radius, 0.0);
    }
    return Sphere{.x = x, .radius = radius};
  };
  return filling<3>(count, classes, seed, layer, pitch, bounds, place);
}

}  // namespace bipot
