#pragma once

#include <functional>
#include <vector>

#include "bench/experiments/packing.h"
#include "bench/problems/compression_scene.h"

namespace bipot {

constexpr int kWindows = 8;  ///< in each direction
constexpr int kLags = 40;

/// A compression from the loose start. `flow`: the steps whose kinetic energy exceeds a tenth of
/// the largest; `jammed`: the last third.
struct Compression {
  /// Pressures over a grid of windows that tile the box.
  struct WindowStatistics {
    double variation = 0;   ///< coefficient of variation over the windows
    double horizontal = 0;  ///< (right half - left half) / sum
  };
  /// Means of a stretch of a compression.
  struct Phase {
    int steps = 0;
    Mat2 stress = Mat2::Zero();     ///< total, over the box                        [Pa]
    Mat2 walls = Mat2::Zero();      ///< Σ f ⊗ p of the walls' forces on the disks over the area
    double wall_pressure = 0;       ///< mean normal force of the walls over their lengths  [Pa]
    double applied_pressure = 0;    ///< of the driving forces                       [Pa]
    double anisotropy = 0;          ///< of the stress of each step, mean
    double fabric_anisotropy = 0;   ///< of the fabric of each step, mean
    double asymmetry = 0;           ///< of the stress, largest
    double variation = 0;           ///< of the windows of each step, mean
    double horizontal = 0;          ///< imbalance of each step, rms
    WindowStatistics mean_windows;  ///< of the mean pressures of the windows
    /// 95 % of `variation` and of the mean over steps of `horizontal`, from 8 blocks of time.
    double variation_bar = kNaN, horizontal_bar = kNaN;
    MeanContacts contacts;
    std::vector<double> correlation;  ///< of the forces against the lag, from 0 to kLags steps
  };
  Scene<2> scene;
  State<2> state, previous;  ///< after the last step and the one before
  PackingRun run, jammed_run;
  Phase flow, jammed;
  /// Of each step.
  std::vector<double> time, pressure, wall_pressure, applied_pressure;
  /// Largest |contact force on a wall - (applied force - mass times acceleration)| over the applied
  /// force, all steps: Newton's law of the walls.
  double wall_balance = 0;
  double solid_fraction = 0, coordination = 0;  ///< at the end; coordination: mean of `jammed`
};
Compression::WindowStatistics window_statistics(const std::vector<double>& pressures);
/// Throws as run_packing does.
Compression run_compression(const Scene<2>& scene, const std::function<bool()>& interrupted);

}  // namespace bipot
