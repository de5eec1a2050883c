#include "core/pictures/colour_map.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace bipot {
namespace {

struct Lab {
  double lightness, a, b;
};

// Lightness falls by 0.33 in each part, hue and chroma change by about 0.11.
constexpr std::array<Lab, 3> kCorners = {
    {{0.97, -0.014, 0.06}, {0.64, -0.07, -0.03}, {0.31, 0.01, -0.11}}};

double encoded(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

double decoded(double x) { return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); }

}  // namespace

Colour sequential_colour(double fraction) {
  const double at = std::clamp(fraction, 0.0, 1.0) * (kCorners.size() - 1);
  const std::size_t part = std::min(static_cast<std::size_t>(at), kCorners.size() - 2);
  const double t = at - static_cast<double>(part);
  const Lab &from = kCorners[part], &to = kCorners[part + 1];
  const double L = from.lightness + t * (to.lightness - from.lightness);
  const double a = from.a + t * (to.a - from.a), b = from.b + t * (to.b - from.b);
  const auto cube = [](double x) { return x * x * x; };
  const double l = cube(L + 0.3963377774 * a + 0.2158037573 * b);
  const double m = cube(L - 0.1055613458 * a - 0.0638541728 * b);
  const double s = cube(L - 0.0894841775 * a - 1.2914855480 * b);
  return {encoded(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          encoded(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          encoded(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

double lightness(const Colour& colour) {
  const double r = decoded(colour.red), g = decoded(colour.green), b = decoded(colour.blue);
  const double l = std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const double m = std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const double s = std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
}

}  // namespace bipot
