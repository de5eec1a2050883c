#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/pictures/force_picture.h"

namespace bipot {

/// Draws disks coloured by pressure: light is low, dark is high, with a colour bar. The extension,
/// .svg or .png, chooses the format. Throws FileError.
///
/// `pressures`: of each disk [Pa], for instance disk_pressures(). The bar ends at
/// options.fill.high, or at colour_bar_end(). Larger values have the last colour, and the bar says
/// so.
void draw_stress_picture(const std::filesystem::path& path, const Scene<2>& scene,
                         const State<2>& state, const std::vector<double>& pressures,
                         const std::string& caption, ForcePictureOptions options = {});

/// End of a colour bar: a round number above 98 % of the values, so that a few heavily loaded disks
/// do not make all others pale. 0 if no value is positive.
double colour_bar_end(std::vector<double> values);

/// Pressure of each disk over its own area. Changes of spin are those of the contact moments
/// (stress_tensor.h).
template <int D>
std::vector<double> disk_pressures(const State<D>& state, double step);

}  // namespace bipot
