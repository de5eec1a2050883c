#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/pictures/force_picture.h"

namespace bipot {

/// Disks coloured by pressure: light is low, dark is high, with a colour bar. The name's end, .svg
/// or .png, chooses the format. Throws FileError.
///
/// `pressures`: of each disk [Pa], for instance disk_pressures(). The bar ends at
/// options.fill.high, or at colour_bar_end(); what lies beyond has the last colour, and the bar
/// says so.
void draw_stress_picture(const std::filesystem::path& path, const Scene<2>& scene,
                         const State<2>& state, const std::vector<double>& pressures,
                         const std::string& caption, ForcePictureOptions options = {});

/// A round number that 98 % of the values are below: few disks carry much more than the others, and
/// a bar as long as the largest would leave all others pale. 0 where no value is positive.
double colour_bar_end(std::vector<double> values);

/// Pressure of each disk over its own area, spins from the contacts' moments (stress_tensor.h).
template <int D>
std::vector<double> disk_pressures(const State<D>& state, double step);

}  // namespace bipot
