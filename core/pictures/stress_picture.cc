#include "core/pictures/stress_picture.h"

#include <algorithm>
#include <cmath>

#include "core/motion/stress_tensor.h"

namespace bipot {
namespace {

constexpr double kShown = 0.98;  // fraction of the disks with a colour of their own

/// The smallest of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten that is at least x > 0.
double round_above(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  for (double digit : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0}) {
    if (digit * power >= x * (1 - 1e-12)) return digit * power;
  }
  return 10 * power;
}

}  // namespace

void draw_stress_picture(const std::filesystem::path& path, const Scene<2>& scene,
                         const State<2>& state, const std::vector<double>& pressures,
                         const std::string& caption, ForcePictureOptions options) {
  options.forces = false;
  options.fill.values = pressures;
  options.fill.label = "pressure in the body";
  options.fill.unit = "Pa";
  if (!(options.fill.high > 0)) options.fill.high = colour_bar_end(pressures);
  draw_force_picture(path, scene, state, caption, options);
}

double colour_bar_end(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(kShown * static_cast<double>(values.size() - 1));
  const double end = values[rank] > 0 ? values[rank] : values.back();
  return end > 0 ? round_above(end) : 0;
}

template <int D>
std::vector<double> disk_pressures(const State<D>& state, double step) {
  std::vector<double> pressures;
  for (const auto& stress : disk_stresses<D>(state, step, contact_moments(state))) {
    pressures.push_back(stress.pressure());
  }
  return pressures;
}

template std::vector<double> disk_pressures(const State<2>&, double);
template std::vector<double> disk_pressures(const State<3>&, double);

}  // namespace bipot
