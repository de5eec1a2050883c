#include "core/scene/generators.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>

namespace bipot {
namespace {

Disk disk_at(double x, double y, double radius) {
  Disk disk;
  disk.x = Vec2(x, y);
  disk.radius = radius;
  return disk;
}

/// The standard fixes the engine's output, not its distributions: these are ours.
class PortableRandom {
 public:
  explicit PortableRandom(std::uint64_t seed) : engine_(seed) {}
  /// In [0, 1), 53 random bits.
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  /// In [0, n), without bias.
  std::uint64_t below(std::uint64_t n) {
    const std::uint64_t limit = engine_.max() - engine_.max() % n;
    std::uint64_t x = engine_();
    while (x >= limit) x = engine_();
    return x % n;
  }

 private:
  std::mt19937_64 engine_;
};

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

}  // namespace

std::vector<Disk> rectangular_lattice(int columns, int rows, double radius, const Vec2& corner) {
  std::vector<Disk> disks;
  disks.reserve(to_size(columns) * to_size(rows));
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      disks.push_back(
          disk_at(corner[0] + (2 * i + 1) * radius, corner[1] + (2 * j + 1) * radius, radius));
    }
  }
  return disks;
}

std::vector<Disk> triangular_lattice(int columns, int rows, double radius, const Vec2& corner) {
  const double rise = std::sqrt(3.0) * radius;
  std::vector<Disk> disks;
  for (int j = 0; j < rows; ++j) {
    const int odd = j % 2;
    for (int i = 0; i < columns - odd; ++i) {
      disks.push_back(
          disk_at(corner[0] + (2 * i + 1 + odd) * radius, corner[1] + radius + j * rise, radius));
    }
  }
  return disks;
}

std::vector<Disk> pyramid(int rows, double radius, const Vec2& corner) {
  const double rise = std::sqrt(3.0) * radius;
  std::vector<Disk> disks;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < rows - j; ++i) {
      disks.push_back(
          disk_at(corner[0] + (2 * i + 1 + j) * radius, corner[1] + radius + j * rise, radius));
    }
  }
  return disks;
}

std::vector<Disk> random_filling(int count, const std::vector<RadiusClass>& classes, double width,
                                 double spacing, std::uint64_t seed, const Vec2& corner) {
  if (count < 0) throw std::invalid_argument(fmt::format("count = {} is negative", count));
  if (classes.empty()) throw std::invalid_argument("no radius classes");
  if (!(spacing >= 0)) {
    throw std::invalid_argument(fmt::format("spacing = {} is not >= 0", spacing));
  }
  PortableRandom random(seed);
  const std::vector<double> radii = drawn_radii(count, classes, random);
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
  std::vector<Disk> disks;
  disks.reserve(radii.size());
  for (int k = 0; k < count; ++k) {
    const double radius = radii[to_size(k)];
    const double free_x = std::max(cell_width - 2 * radius, 0.0);
    const double free_y = std::max(pitch - 2 * radius, 0.0);
    const double x = corner[0] + (k % columns) * cell_width + radius + random.uniform() * free_x;
    const double y = corner[1] + (k / columns) * pitch + radius + random.uniform() * free_y;
    disks.push_back(disk_at(x, y, radius));
  }
  return disks;
}

}  // namespace bipot
