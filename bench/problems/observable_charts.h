#pragma once

#include <filesystem>

namespace bipot {

/// Draws what a run has measured (core/run_files/observable_output.h) into its folder: over time
/// coordination, solid fraction and sliding share (observables_state), τ/P and inertial number
/// (observables_flow), the flux through lines or faces (observables_flux); the mean profile (observables_velocity,
/// observables_fraction, observables_stress) and the distribution of forces (observables_forces), each as .svg, .csv and .gp.
/// Throws FileError.
void draw_observables(const std::filesystem::path& folder);

}  // namespace bipot
