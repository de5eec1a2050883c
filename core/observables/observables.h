#pragma once

#include <vector>

#include "core/motion/state.h"
#include "core/motion/stress_tensor.h"
#include "core/scene/observable_choice.h"

namespace bipot {

/// What a state says of its sample, or of a window of it. A disk counts where its centre is, a contact where
/// it touches; loaded contacts have s_n > 0. Disks that are glued to a wall are part of the wall. Undefined values are NaN.
struct Observables {
  int disks = 0;                    ///< in the window
  int rattlers = 0;                 ///< of them: disks that nothing holds, see find_rattlers()
  int contacts = 0;                 ///< loaded
  int sliding = 0;                  ///< of them, those on the cone's edge
  double coordination = 0;          ///< loaded contacts of a disk, mean
  double coordination_without = 0;  ///< the same without rattlers and their contacts
  double solid_fraction = 0;        ///< area of disks over area; overlaps count twice
  Mat2 fabric = Mat2::Zero();       ///< mean of n ⊗ n over loaded contacts
  MeanStress stress;                ///< core/motion/stress_tensor.h
  Mat2 velocity_gradient = Mat2::Zero();  ///< dv_i/dx_j, least squares over the disks   [1/s]
  double mean_mass = 0;                   ///< of a disk                                 [kg]

  double sliding_share() const;
  /// Magnitude of the deviator of the rate of strain, √(2 D':D'): the shear rate of simple shear [1/s]
  double shear_rate() const;
  /// Shear rate × √(m/P) (da Cruz, Emam, Prochnow, Roux and Chevoir, PRE 72, 021309, 2005), m the
  /// mean mass of a disk, P the pressure: disks are cylinders of unit length.
  double inertial_number() const;
  /// τ/P = (σ₁ - σ₂)/(σ₁ + σ₂) of the stress.
  double friction() const;
};

/// Throws std::invalid_argument for a window without area.
Observables observe(const Scene& scene, const State& state, const ObservableChoice& choice);

/// Which disks nothing holds: those with fewer than two loaded contacts, or fewer than three in
/// scenes that have neither friction nor gravity; contacts with rattlers do not count, so it is
/// repeated until nothing changes.
std::vector<bool> find_rattlers(const Scene& scene, const State& state);

/// Means in bins across an axis. Area counts exactly by what of a disk lies in the bin, velocities and spins
/// are weighted with it. NaN in bins without disks.
struct Profile {
  std::vector<double> position;        ///< middle of each bin                          [m]
  std::vector<double> solid_fraction;  ///< of the bin, as wide as the window or the sample
  std::vector<double> vx, vy, spin;    ///< means                                       [m/s, rad/s]
  /// Half the mean of |v - mean of the bin|²                                            [m²/s²]
  std::vector<double> temperature;
};
Profile observe_profile(const State& state, double step, const ObservableChoice& choice);

/// Mass per time across a line: Σ m/(π a²) × (length of the line in the disk) × velocity across.
/// Exact for any line that no disk passes at its ends: its integral in time is the mass that has
/// crossed.                                                                            [kg/s]
double line_flux(const State& state, const FluxLine& line);

/// Loaded normal forces over their mean, in bins up to choice.force_limit; the last bin has all
/// that is beyond as well.
struct ForceDistribution {
  double mean = 0;          ///< of s_n/h over loaded contacts                          [N]
  std::vector<int> counts;  ///< one for each bin
};
ForceDistribution observe_forces(const State& state, double step, const ObservableChoice& choice);

/// Area of the disk about x that lies in the rectangle from low to high.               [m²]
double area_in_rectangle(const Vec2& x, double radius, const Vec2& low, const Vec2& high);

}  // namespace bipot
