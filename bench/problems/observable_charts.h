#pragma once

#include <filesystem>
#include <optional>

#include "core/scene/observable_choice.h"

namespace bipot {

/// Writes charts of the measured observables of a run (core/run_files/observable_output.h) into its
/// folder, each as .csv, .gp and, if `draw`, as .svg, by gnuplot:
///   observables_state      coordination, solid fraction and sliding share over time
///   observables_flow       τ/P and inertial number over time
///   observables_flux       flux through lines or faces over time
///   observables_velocity, observables_fraction, observables_stress   means over bins of `profile`
///   observables_forces     distribution of forces
/// Throws FileError.
void write_observable_charts(const std::filesystem::path& folder,
                             const std::optional<ProfileChoice>& profile, bool draw);

}  // namespace bipot
