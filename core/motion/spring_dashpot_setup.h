#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace bipot {

/// Restitution of a linear spring and dashpot of damping ratio zeta = c / (2 √(k m)) whose contact
/// ends when its force would become tensile: with w = √(k/m),
///   e = exp(-2 zeta acos(zeta) / √(1 - zeta²)) after the time 2 acos(zeta) / (w √(1 - zeta²))
/// (for zeta > 1 acosh and √(zeta² - 1)); decreasing from 1, e(1) = exp(-2). The end condition is
/// that of Schwager and Pöschel, Granular Matter 9 (2007) 465-469. Without it, that is with
/// adhesion at the end of every contact, e = exp(-pi zeta / d) after pi / (w d), d = √(1 - zeta²).
double restitution_of_damping(double zeta);
/// Its inverse, cut off at kMaxDamping: what restitution below restitution_of_damping(kMaxDamping)
/// would need is out of an explicit method's reach.
double damping_of_restitution(double e_n);
inline constexpr double kMaxDamping = 2;  ///< e = 0.048: 0.2 % of the energy comes back

/// True when a chain of bodies that touch (gap <= touching, in m) leads from every disk to a wall:
/// nothing falls freely.
bool supported_by_walls(const Scene<2>& scene, double touching);

/// The numbers of the spring-dashpot model of a scene. They depend on the scene alone, not on the
/// state: a restarted run goes on with the same ones.
///
/// Stiffness, where none is given: the larger of
///   F / (o r)          F: mean static force on a contact at the bottom, weight over the number
///                      of columns (width over the mean diameter), or a driven wall's force over
///                      the number of disks along it,
///   m v² / (10 o r)²   v: speed of an impact, the largest initial speed and what the fall from
///                      the loosest to a dense arrangement adds; m: the heaviest disk,
/// so that overlaps at rest are about `o` and those of impacts at most about 10 o of the smallest
/// radius r. Force chains carry a few times F.
///
/// Stable step: the scheme (core/motion/spring_dashpot.h) on M x'' + C x' + K x = 0 with K, C
/// symmetric is stable while dt² x'Kx + 2 dt x'Cx <= 4 x'Mx for all x. Gershgorin, disk by disk,
/// with as many contacts z at once as fit around it (6 for equal disks):
///   dt² kappa + 2 dt chi <= 4,
///   kappa = Σ_z f max(k_n/m, k_t (1/m + a²/I)),  chi alike with the dashpots,
/// f = 2 between disks (both ends move), 1 at walls. (Slip makes K unsymmetric and lies outside of
/// this bound; a step whose contacts make energy fails.) The substep is safety x that, but at most
/// 1/(20 + 40 zeta) of the shortest half period, so that an impact is resolved.
struct SpringDashpotSetup {
  double stiffness = 0;             ///< k_n                                             [N/m]
  double tangential_stiffness = 0;  ///< k_t                                             [N/m]
  std::vector<double> damping;      ///< zeta of each entry of Scene::laws               [-]
  double load_force = 0;            ///< F above; 0 with a given stiffness               [N]
  double load_speed = 0;            ///< v above                                         [m/s]
  double critical_step = 0;         ///< largest stable substep                          [s]
  double substep = 0;               ///< h / substeps                                    [s]
  int substeps = 1;                 ///< in each step of the scene
  /// What the scene asks for and the model does not represent, one sentence each.
  std::vector<std::string> departures;
};

/// Throws std::invalid_argument when a substep above the critical one is asked for, or nothing in
/// the scene says how stiff its contacts must be.
SpringDashpotSetup spring_dashpot_setup(const Scene<2>& scene);

}  // namespace bipot
