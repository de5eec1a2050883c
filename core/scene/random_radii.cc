#include "core/scene/random_radii.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace bipot {

void check_filling(int count, const std::vector<RadiusClass>& classes, double spacing) {
  if (count < 0) throw std::invalid_argument(fmt::format("count = {} is negative", count));
  if (classes.empty()) throw std::invalid_argument("no radius classes");
  if (!(spacing >= 0)) {
    throw std::invalid_argument(fmt::format("spacing = {} is not >= 0", spacing));
  }
}

void refuse_filling(int fits, int asked, double height) {
  std::string message =
      fmt::format("fits {} of {}: make its room larger, or the bodies fewer", fits, asked);
  if (std::isfinite(height)) {
    const double step = std::pow(10.0, std::floor(std::log10(height)) - 3);
    message += fmt::format("; height = {:g} holds all", std::ceil(height / step) * step);
  }
  throw std::invalid_argument(message);
}

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

}  // namespace bipot
