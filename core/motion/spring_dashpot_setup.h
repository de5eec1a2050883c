#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace bipot {

/// Restitution of a linear spring and dashpot with damping ratio zeta = c / (2 √(k m)). The contact
/// ends when its force would become tensile (Schwager and Pöschel, Granular Matter 9 (2007)
/// 465-469). With w = √(k/m),
///   e = exp(-2 zeta acos(zeta) / √(1 - zeta²)) after the time 2 acos(zeta) / (w √(1 - zeta²))
/// (for zeta > 1 acosh and √(zeta² - 1)); it decreases from 1, with e(1) = exp(-2). Without this
/// end condition, that is with adhesion, e = exp(-pi zeta / d) after pi / (w d), d = √(1 - zeta²).
double restitution_of_damping(double zeta);
/// The inverse, cut off at kMaxDamping: more damping is out of reach of an explicit method.
double damping_of_restitution(double e_n);
inline constexpr double kMaxDamping = 2;  ///< e = 0.048: almost no energy is returned

/// True if a chain of touching bodies (gap <= touching, in m) leads from every disk to a wall:
/// nothing falls freely.
template <int D>
bool supported_by_walls(const Scene<D>& scene, double touching);

/// The parameters of the spring-dashpot model of a scene. They depend on the scene alone, not on
/// the state: a restarted run continues with the same ones.
///
/// Stiffness, if none is given: the larger of
///   F / (o r)          F: mean static force on a contact at the bottom, weight over the number
///                      of columns (base over a power of the mean diameter), or a driven wall's
///                      force over the number of bodies along it,
///   m v² / (10 o r)²   v: speed of an impact, the largest initial speed plus that of the fall
///                      from the loosest to a dense arrangement; m: the heaviest disk.
/// Overlaps at rest are then about `o` and those of impacts at most about 10 o of the smallest
/// radius r. Force chains carry a few times F.
///
/// Stable step: the scheme (core/motion/spring_dashpot.h) on M x'' + C x' + K x = 0 with symmetric
/// K, C is stable if dt² x'Kx + 2 dt x'Cx <= 4 x'Mx for all x. By Gershgorin, disk by disk, with
/// the largest number z of contacts that fit around it (6 for equal disks, 13 for spheres):
///   dt² kappa + 2 dt chi <= 4,
///   kappa = Σ_z f max(k_n/m, k_t (1/m + a²/I)),  chi alike with the dashpots,
/// f = 2 between disks (both ends move), 1 at walls. Slip makes K unsymmetric, and this bound does
/// not cover it; a step whose contacts create energy fails. The substep is safety times that bound.
/// It is at most 1/(20 + 40 zeta) of the shortest half period, so that an impact is resolved.
struct SpringDashpotSetup {
  double stiffness = 0;             ///< k_n                                             [N/m]
  double tangential_stiffness = 0;  ///< k_t                                             [N/m]
  std::vector<double> damping;      ///< zeta of each entry of Scene::laws               [-]
  double critical_step = 0;         ///< largest stable substep                          [s]
  double substep = 0;               ///< h / substeps                                    [s]
  int substeps = 1;                 ///< in each step of the scene
  /// Requests of the scene that the model does not represent, one sentence each.
  std::vector<std::string> departures;
};

/// Why a sound scene cannot have springs, one sentence; empty: it can.
template <int D>
std::string no_springs(const Scene<D>& scene);

/// Throws std::invalid_argument where there are no_springs(), if the scene asks for a substep above
/// the critical one, or if nothing in it determines the stiffness of its contacts.
template <int D>
SpringDashpotSetup spring_dashpot_setup(const Scene<D>& scene);

}  // namespace bipot
