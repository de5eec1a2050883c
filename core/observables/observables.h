#pragma once

#include <type_traits>
#include <vector>

#include "core/motion/state.h"
#include "core/motion/stress_tensor.h"
#include "core/scene/observable_choice.h"

namespace bipot {

/// τ/P of a stress, see Observables::friction().
template <int D>
double stress_ratio(const Mat<D>& stress);

/// Observables of a sample, or of a window of it, from one state. A disk counts if its centre is in
/// the window, a contact if its point is. Loaded contacts push, or cohesion holds them. Disks glued to a wall are
/// part of the wall. A cluster counts as one body at its centre of mass, with all contacts of its
/// disks and the area of their union. Undefined values are NaN.
template <int D>
struct Observables {
  int bodies = 0;                   ///< in the window
  int rattlers = 0;                 ///< of them: disks that nothing holds, see find_rattlers()
  int contacts = 0;                 ///< loaded
  int sliding = 0;                  ///< of them, those on the cone's edge
  double coordination = 0;          ///< loaded contacts of a disk, mean
  double coordination_without = 0;  ///< the same without rattlers and their contacts
  double solid_fraction = 0;  ///< area of disks over area (volumes in 3D); overlaps count twice
  Mat<D> fabric = Mat<D>::Zero();             ///< mean of n ⊗ n over loaded contacts
  MeanStress<D> stress;                       ///< core/motion/stress_tensor.h
  Mat<D> velocity_gradient = Mat<D>::Zero();  ///< dv_i/dx_j, least squares over the disks   [1/s]
  double mean_mass = 0;      ///< of a disk                                              [kg]
  double mean_diameter = 0;  ///< 3D: of spheres of the same volumes                    [m]
  double density = 0;        ///< 3D: mass over volume of the spheres           [kg/m³]

  double sliding_share() const {
    return contacts > 0 ? static_cast<double>(sliding) / contacts : kNaN;
  }
  /// Shear rate: magnitude of the deviator of the rate of strain, √(2 D':D'). [1/s]
  double shear_rate() const;
  /// In 2D shear rate × √(m/P), m the mean mass of a disk, P the pressure; disks are cylinders of
  /// unit length (da Cruz, Emam, Prochnow, Roux and Chevoir, PRE 72, 021309, 2005). In 3D shear
  /// rate × d √(ρ/P) (GDR MiDi, EPJ E 14, 341, 2004).
  double inertial_number() const;
  /// In 2D τ/P = (σ₁ - σ₂)/(σ₁ + σ₂) of the stress. In 3D √(½ τ:τ)/P with its deviator τ, the same
  /// in simple shear (Jop, Forterre and Pouliquen, Nature 441, 727, 2006).
  double friction() const { return stress_ratio<D>(stress.total()); }
};

/// Throws std::invalid_argument for a window without area or volume.
template <int D>
Observables<D> observe(const Scene<D>& scene, const State<D>& state,
                       const std::type_identity_t<ObservableChoice<D>>& choice);

/// Marks the rattlers: disks with fewer loaded contacts than equilibrium needs. In 2D the limit is
/// two, or three in scenes with neither friction nor gravity. In 3D it is two with friction, three
/// with gravity alone, four with neither. Contacts with rattlers do not count; therefore the search
/// is repeated until nothing changes.
template <int D>
std::vector<bool> find_rattlers(const Scene<D>& scene, const State<D>& state);

/// Means in bins across an axis. Each disk counts with the exact part of its area (3D: volume) in
/// the bin, which also weights velocities and spins. Bins without disks have NaN, but for stress
/// and solid fraction.
template <int D>
struct Profile {
  std::vector<double> position;  ///< middle of each bin                          [m]
  /// Fraction of the bin, which is as wide as the window, the cell, the region between half-planes,
  /// or the sample. In 3D without a window, the parts cut off by hollow cylinders do not count.
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
/// For lines whose ends no disk passes it is exact: its time integral is the mass that has crossed.
/// A cluster counts with the line in the union of its disks, and with its spin. [kg/s]
double mass_flux(const State<2>& state, const FluxLine& line);
/// Mass per time across a face: Σ m/(4/3 π a³) × (area of the face in the sphere) × normal
/// velocity. Its time integral is the mass that has crossed the face; of spheres at its edge, the
/// part that has. In a periodic cell an infinite plane has a normal along an axis, and every face
/// lies in the cell.
double mass_flux(const State<3>& state, const FluxFace& face);

/// Distribution of loaded normal forces over their mean, in bins up to choice.force_limit. The last
/// bin includes all larger forces.
struct ForceDistribution {
  double mean = 0;          ///< of s_n/h over loaded contacts                          [N]
  std::vector<int> counts;  ///< one for each bin
};
template <int D>
ForceDistribution observe_forces(const State<D>& state, double step,
                                 const std::type_identity_t<ObservableChoice<D>>& choice);

}  // namespace bipot
