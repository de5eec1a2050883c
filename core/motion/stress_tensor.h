#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "core/base/types.h"
#include "core/motion/time_stepping.h"

namespace bipot {

using Mat2 = Eigen::Matrix2d;

/// Mean stress of a set of disks over an area, in 3D of spheres over a volume, at a step of the
/// simulation. Pressure is positive (the granular sign: minus the mean Cauchy stress). The first
/// index is the direction of the force, the second that of the normal. Disks are cylinders of unit
/// length, so that newtons per metre are pascals.
///
///   total   = contact + kinetic + spin                                                      [Pa]
///   contact = 1/V Σ_c f ⊗ l                            Love 1927, Weber 1966: virial of contacts
///   kinetic = 1/V Σ_i m v' ⊗ v'                        fluctuations v' about the mean velocity
///   spin    = 1/V Σ_i (dL/dt) / 2 · [0 -1; 1 0]        Fortin, Millet and de Saxcé 2003
///             (in 3D half the matrix of dL/dt ×)
///
/// f is the force s/h on the first body of a contact. l is the branch from the second centre to the
/// first (from the surface of a wall), at mid-step, where the impulses act (38). In a periodic cell
/// l is the branch to the image of the second disk, and v' excludes the homogeneous deformation of
/// the cell.
///
/// Reason for the three parts: averaging the Cauchy stress inside a disk gives Σ f ⊗ r - ∫ ρ a ⊗ r.
/// Its last term is I/2 (α [0 -1; 1 0] - ω² 1) for a rigid rotation. The ω² part (centripetal)
/// cancels the kinetic part of that rotation; the α part is `spin`. The contact part alone has the
/// antisymmetric part (Σ dL/dt)/2V: it is symmetric if and only if the moments balance. The sum is
/// symmetric whenever the spins follow from the moments of the contacts.
///
/// A cluster is one body: its branches end in its centre of mass, m, v and L are its own. For a
/// body that is not round, ω² leaves a part without trace. No virial of centres of mass has it; it
/// is omitted here too.
///
/// Overlaps: the centres of a contact lie d = a_i + a_j + gap apart, but the step turns disk i with
/// the lever arm a_i. The difference is a couple that acts on no disk. Therefore [ours] the
/// antisymmetric part uses the arms, the symmetric one d; they agree without overlap. Hence two
/// identities hold to round-off at every step, for any impulses. These are the symmetry of `total`,
/// and the virial theorem (d/dt Σ m v ⊗ x against the forces of the walls).
template <int D>
struct MeanStress {
  double area = 0;                  ///< V, > 0: an area, in 3D a volume              [m² | m³]
  Mat<D> contact = Mat<D>::Zero();  ///<                                                      [Pa]
  Mat<D> kinetic = Mat<D>::Zero();
  Mat<D> spin = Mat<D>::Zero();
  Mat<D> total() const { return contact + kinetic + spin; }
  /// The mean of the principal stresses of the total.
  double pressure() const { return total().trace() / D; }
};

/// dL of each disk over the step of a state, from the moments of the contacts [N m s]
template <int D>
std::vector<Spin<D>> contact_moments(const State<D>& state);
/// The same from the change of the spins, I (ω⁺ - ω⁻). Equal to the moments of the contacts to
/// round-off if `after` follows from `before` by one step.
template <int D>
std::vector<Spin<D>> spin_changes(const State<D>& before, const State<D>& after);

/// Stress of the whole sample. `step`: h > 0. `area`: see sample_area.h and sample_volume.h.
/// `moments`: dL of each disk. Velocities are those at the end of the step. The virial theorem
/// needs the mean of the kinetic parts at both ends, which an average over steps gives.
template <int D>
MeanStress<D> sample_stress(const State<D>& state, double step, double area,
                            std::span<const std::type_identity_t<Spin<D>>> moments);

/// Stress in a rectangle, in 3D a box. Each contact counts by the fraction of its branch in the
/// window (indicator function in Goldhirsch's coarse graining, Granular Matter 12, 2010). Disks
/// count by their centres at mid-step; v' is relative to their mean velocity in the window. Lower
/// and left edges belong to the window, upper and right ones do not. A periodic state must be
/// wrapped (core/motion/periodic_state.h). Branches that cross the edge of the cell count on both
/// sides: the contact parts of windows that tile the sample add up to that of the sample. Branches
/// that a window cuts leave an antisymmetric part.
template <int D = 2>
MeanStress<D> window_stress(const State<D>& state, double step, const Box<D>& window,
                            std::span<const std::type_identity_t<Spin<D>>> moments);

/// Stress of each disk over its own area π a² (in 3D: volume): the mean stress of its material,
/// with the kinetic part relative to the sample's mean velocity. A contact is divided between its
/// two disks in proportion to their radii. Σ π a² σ_i = V σ of the sample, part by part. All disks
/// of a cluster have the stress of the cluster over the area of its union, which counts once.
template <int D>
std::vector<MeanStress<D>> disk_stresses(const State<D>& state, double step,
                                         std::span<const std::type_identity_t<Spin<D>>> moments);

/// Mean of n ⊗ n over the loaded contacts; trace 1, zero without any.
template <int D>
Mat<D> fabric_tensor(const State<D>& state);

/// (σ₁ - σ₂)/(σ₁ + σ₂) of the symmetric part: 0 isotropic, 1 uniaxial. NaN if the trace is 0.
double anisotropy(const Mat2& tensor);

/// σ_xy - σ_yx| / (σ_xx + σ_yy); NaN if the trace is 0.
double asymmetry(const Mat2& tensor);

}  // namespace bipot
