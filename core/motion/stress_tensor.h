#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/motion/time_stepping.h"
#include "core/scene/scene_box.h"

namespace bipot {

using Mat2 = Eigen::Matrix2d;

/// Mean stress of a set of disks over an area, in space of spheres over a volume, at a step of the
/// simulation. Pressure is positive
/// (the granular sign: minus the mean Cauchy stress), first index the direction of the force,
/// second that of the normal. Disks are cylinders of unit length, so newtons per metre are pascals.
///
///   total   = contact + kinetic + spin                                                      [Pa]
///   contact = 1/V Σ_c f ⊗ l                            Love 1927, Weber 1966: virial of contacts
///   kinetic = 1/V Σ_i m v' ⊗ v'                        fluctuations v' about the mean velocity
///   spin    = 1/V Σ_i (dL/dt) / 2 · [0 -1; 1 0]        Fortin, Millet and de Saxcé 2003
///             (in space half the matrix of dL/dt ×)
///
/// In a periodic cell l is the branch to the image of the second disk, and v' does not count the
/// homogeneous deformation of the cell.
///
/// f is the force s/h on the first body of a contact, l the branch from the second centre to the
/// first (from the wall's surface for a wall), at mid-step, where the impulses act (38).
///
/// Why these three: averaging the Cauchy stress inside a disk gives Σ f ⊗ r - ∫ ρ a ⊗ r, whose last
/// term is I/2 (α [0 -1; 1 0] - ω² 1) for a rigid rotation. Its ω² part (the pull of a turning disk
/// on itself) is cancelled by the kinetic part of that rotation, the α part is `spin`. A contact
/// part alone has the antisymmetric part (Σ dL/dt)/2V: it is symmetric if and only if the moments
/// balance. The sum is symmetric whenever the spins follow from the contacts' moments.
///
/// A cluster is one body: its branches end in its centre of mass, m, v and L are its own. (ω² of a body that is not round
/// leaves a part without trace, which no virial of centres of mass has, and which is left out here too.)
///
/// Overlaps: the centres of a contact lie d = a_i + a_j + gap apart, but the step turns disk i with
/// the lever arm a_i. What the arms leave out is a couple that no disk feels, so [ours] the
/// antisymmetric part is taken with the arms, the symmetric one with d; they are the same where
/// nothing overlaps. Hence two identities hold to round-off at every step, for any impulses: the
/// symmetry of `total`, and the virial theorem (d/dt Σ m v ⊗ x against the forces of the walls).
template <int D>
struct MeanStress {
  double area = 0;                  ///< V, > 0: an area, in space a volume              [m² | m³]
  Mat<D> contact = Mat<D>::Zero();  ///<                                                      [Pa]
  Mat<D> kinetic = Mat<D>::Zero();
  Mat<D> spin = Mat<D>::Zero();
  Mat<D> total() const { return contact + kinetic + spin; }
  /// The mean of the principal stresses of the total.
  double pressure() const { return total().trace() / D; }
};

/// dL of each disk over the step of a state, as the contacts' moments give it           [N m s]
template <int D>
std::vector<Spin<D>> contact_moments(const State<D>& state);
/// The same as the spins have changed, I (ω⁺ - ω⁻). Equal to the contacts' moments to round-off
/// when `after` was made from `before` by one step.
template <int D>
std::vector<Spin<D>> spin_changes(const State<D>& before, const State<D>& after);

/// Of the whole sample. `step`: h > 0; `area`: see sample_area.h and sample_volume.h; `moments`: dL of each disk.
/// Velocities are those at the end of the step; the mean of kinetic parts at its two ends is what
/// the virial theorem asks for, and what an average over steps gives.
template <int D>
MeanStress<D> sample_stress(const State<D>& state, double step, double area,
                            std::span<const std::type_identity_t<Spin<D>>> moments);

/// Over a rectangle, in space a box: each contact counts by the share of its branch that lies in the window
/// (indicator function in Goldhirsch's coarse graining, Granular Matter 12, 2010), disks by their
/// centres at mid-step; v' is about the mean velocity of the disks in the window. Lower and left
/// edges belong to the window, upper and right ones do not; of a periodic scene the state must be
/// wrapped (core/motion/periodic_state.h), and branches that cross the cell's edge count on both sides: the contact parts of windows that tile
/// the sample add up to the sample's. Branches that a window cuts leave an antisymmetric part.
template <int D = 2>
MeanStress<D> window_stress(const State<D>& state, double step, const Box<D>& window,
                            std::span<const std::type_identity_t<Spin<D>>> moments);

/// Of each disk over its own area π a² (in space: volume): the mean stress of its material, with the kinetic part of
/// its motion about the sample's mean velocity. A contact goes to its two disks in proportion to
/// their radii. Σ π a² σ_i = V σ of the sample, part by part. The disks of a cluster all have that of the cluster over
/// the area of its union, which counts once.
template <int D>
std::vector<MeanStress<D>> disk_stresses(const State<D>& state, double step,
                                         std::span<const std::type_identity_t<Spin<D>>> moments);

/// Mean of n ⊗ n over the contacts that carry force; trace 1, zero without any.
template <int D>
Mat<D> fabric_tensor(const State<D>& state);

/// (σ₁ - σ₂)/(σ₁ + σ₂) of the symmetric part: 0 isotropic, 1 uniaxial. NaN where the trace is 0.
double anisotropy(const Mat2& tensor);

/// |σ_xy - σ_yx| / (σ_xx + σ_yy); NaN where the trace is 0.
double asymmetry(const Mat2& tensor);

}  // namespace bipot
