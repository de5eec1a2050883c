#pragma once

#include <filesystem>

namespace bipot {

/// Draws the measured observables of a run (core/run_files/observable_output.h) into its folder,
/// each as .svg, .csv and .gp:
///   observables_state      coordination, solid fraction and sliding share over time
///   observables_flow       τ/P and inertial number over time
///   observables_flux       flux through lines or faces over time
///   observables_velocity, observables_fraction, observables_stress   mean profiles
///   observables_forces     distribution of forces
/// Throws FileError.
void draw_observables(const std::filesystem::path& folder);

}  // namespace bipot
