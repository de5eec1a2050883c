#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/portable_random.h"
#include "core/scene/generators.h"

namespace bipot {

/// Throws std::invalid_argument for a count, classes or a spacing that no filling can have.
void check_filling(int count, const std::vector<RadiusClass>& classes, double spacing);

/// `count` radii in random order, whose numbers per class follow by largest remainders. Throws
/// std::invalid_argument for classes without sound radii and shares.
std::vector<double> drawn_radii(int count, const std::vector<RadiusClass>& classes,
                                PortableRandom& random);

/// Throws std::invalid_argument: so many bodies have a place, fewer than asked for. `height` would
/// hold all, in m; infinite: unknown.
[[noreturn]] void refuse_filling(int fits, int asked, double height);

/// `fill(count)`: bodies in their places, fewer than `count` where no more have one. Throws
/// std::invalid_argument with a number for which all have one, and the `height` that holds all.
template <class Fill>
auto whole_filling(int count, double height, const Fill& fill) {
  auto bodies = fill(count);
  int fits = static_cast<int>(bodies.size());
  if (fits == count) return bodies;
  // Fewer bodies have other sizes.
  for (int made = fits; (made = static_cast<int>(fill(fits).size())) < fits;) fits = made;
  refuse_filling(fits, count, height);
}

/// The height of the layers that hold `count` bodies, one in each cell; infinite with walls, where
/// cells may stay empty.
template <int D>
double height_for(int count, std::int64_t layer, double pitch, const FillingBounds<D>& bounds) {
  return bounds.holds ? kInfinity : pitch * static_cast<double>((count + layer - 1) / layer);
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

}  // namespace bipot
