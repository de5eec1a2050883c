#pragma once

#include <type_traits>
#include <vector>

#include "core/motion/state.h"
#include "core/motion/stress_tensor.h"
#include "core/scene/observable_choice.h"

namespace bipot {

/// What a state says of its sample, or of a window of it. A disk counts where its centre is, a contact where
/// it touches; loaded contacts have s_n > 0. Disks that are glued to a wall are part of the wall. A cluster is one body,
/// where its centre of mass is: it counts once where disks do, with all contacts of its disks, and the area of their union.
/// Undefined values are NaN.
template <int D>
struct Observables {
  int bodies = 0;                   ///< in the window
  int rattlers = 0;                 ///< of them: disks that nothing holds, see find_rattlers()
  int contacts = 0;                 ///< loaded
  int sliding = 0;                  ///< of them, those on the cone's edge
  double coordination = 0;          ///< loaded contacts of a disk, mean
  double coordination_without = 0;  ///< the same without rattlers and their contacts
  double solid_fraction = 0;  ///< area of disks over area (volumes in space); overlaps count twice
  Mat<D> fabric = Mat<D>::Zero();             ///< mean of n ⊗ n over loaded contacts
  MeanStress<D> stress;                       ///< core/motion/stress_tensor.h
  Mat<D> velocity_gradient = Mat<D>::Zero();  ///< dv_i/dx_j, least squares over the disks   [1/s]
  double mean_mass = 0;      ///< of a disk                                              [kg]
  double mean_diameter = 0;  ///< in space: of a sphere                                   [m]
  double density = 0;        ///< in space: mass over volume of the spheres           [kg/m³]

  double sliding_share() const;
  /// Magnitude of the deviator of the rate of strain, √(2 D':D'): the shear rate of simple shear [1/s]
  double shear_rate() const;
  /// Shear rate × √(m/P) (da Cruz, Emam, Prochnow, Roux and Chevoir, PRE 72, 021309, 2005), m the
  /// mean mass of a disk, P the pressure: disks are cylinders of unit length. In space shear rate × d √(ρ/P) (GDR
  /// MiDi, EPJ E 14, 341, 2004).
  double inertial_number() const;
  /// τ/P = (σ₁ - σ₂)/(σ₁ + σ₂) of the stress; in space √(½ τ:τ)/P with its deviator τ (Jop, Forterre and
  /// Pouliquen, Nature 441, 727, 2006), which is the same in simple shear.
  double friction() const;
};

/// τ/P of a stress, see Observables::friction().
template <int D>
double stress_ratio(const Mat<D>& stress);

/// Throws std::invalid_argument for a window without area or volume.
template <int D>
Observables<D> observe(const Scene<D>& scene, const State<D>& state,
                       const std::type_identity_t<ObservableChoice<D>>& choice);

/// Which disks nothing holds: those with fewer than two loaded contacts, or fewer than three in
/// scenes that have neither friction nor gravity; contacts with rattlers do not count, so it is
/// repeated until nothing changes. In space: fewer than two with friction, three with gravity alone, four with neither.
template <int D>
std::vector<bool> find_rattlers(const Scene<D>& scene, const State<D>& state);

/// Means in bins across an axis. Area (in space volume) counts exactly by what of a disk lies in the bin, velocities
/// and spins are weighted with it. NaN in bins without disks, but for stress and solid fraction.
template <int D>
struct Profile {
  std::vector<double> position;  ///< middle of each bin                          [m]
  /// Of the bin, which is as wide as the window, the cell, what half-planes across leave, or the sample; in space less what
  /// hollow cylinders cut off, unless there is a window.
  std::vector<double> solid_fraction;
  std::vector<Vec<D>> velocity;     ///< means                                       [m/s]
  std::vector<Spin<D>> spin;        ///<                                           [rad/s]
  std::vector<double> temperature;  ///< mean of |v - mean of the bin|², over D           [m²/s²]
  std::vector<Mat<D>> stress;       ///< window_stress() of the bin, all parts            [Pa]
};
template <int D>
Profile<D> observe_profile(const State<D>& state, double step,
                           const std::type_identity_t<ObservableChoice<D>>& choice);

/// Mass per time across a line: Σ m/(π a²) × (length of the line in the disk) × velocity across.
/// Exact for any line that no disk passes at its ends: its integral in time is the mass that has
/// crossed. Of a cluster the line in the union of its disks counts, with its spin.                                                                            [kg/s]
double mass_flux(const State<2>& state, const FluxLine& line);
/// Across a face: Σ m/(4/3 π a³) × (area of the face in the sphere) × velocity along the normal; its integral is the
/// mass that has crossed there, of spheres that pass at its edge the part that did. In a periodic cell a plane without ends
/// has a normal along an axis, and every face lies in the cell.
double mass_flux(const State<3>& state, const FluxFace& face);

/// Loaded normal forces over their mean, in bins up to choice.force_limit; the last bin has all
/// that is beyond as well.
struct ForceDistribution {
  double mean = 0;          ///< of s_n/h over loaded contacts                          [N]
  std::vector<int> counts;  ///< one for each bin
};
template <int D>
ForceDistribution observe_forces(const State<D>& state, double step,
                                 const std::type_identity_t<ObservableChoice<D>>& choice);

}  // namespace bipot
