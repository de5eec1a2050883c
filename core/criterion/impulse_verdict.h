#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.h"
#include "core/criterion/contact_error.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// A way in which one contact violates the law, with its energy in the criterion.
struct ContactFault {
  enum class Kind {
    kPulls,          ///< s_n < 0 as given; size s_n                                       [N s]
    kOutsideCone,    ///< |s_t| > mu s_n as given; size |s_t| - mu s_n                     [N s]
    kBeyondRolling,  ///< |m| > mu_r s_n as given; size |m| - mu_r s_n, or of the spin   [N m s]
    kPenetrates,     ///< u_n < 0; size u_n                                                [m/s]
    kActsAcrossGap,  ///< s_n > 0 although u_n > 0; size u_n                                  [m/s]
    kSlidesInside,   ///< |u_t| > 0 although |s_t| < mu s_n; size |u_t|                       [m/s]
    kNotOpposed,     ///< on the cone's edge, but s_t does not oppose u_t; size |u_t|      [m/s]
    kRollsInside,    ///< |w| > 0 although |m| < mu_r s_n; size |w|, or of the spin      [rad/s]
    kRollsAlong      ///< at that bound, but m does not oppose w; size |w|               [rad/s]
  };
  Kind kind;
  double size = 0;
  double energy = 0;  ///< > 0                                                              [J]
};
std::string_view to_string(ContactFault::Kind kind);

/// One judged contact, in physical variables (without row_scale).
struct JudgedContact {
  int contact = -1;
  double mu = 0;     ///< physical friction coefficient                                     [-]
  int tangents = 0;  ///< components of s and u after the normal that slide
  Vector s;          ///< d, impulse as given                                  [N s | N m s]
  Vector u;          ///< d, velocity from the impulses, see ImpulseVerdict    [m/s | rad/s]
  double share = 0;  ///< of all contacts' energy in the criterion (and off the cone), 0 to 1 [-]
  std::vector<ContactFault> faults;  ///< from the largest energy down
};

/// As "contact 12: penetrates at 3.2e-03 m/s; slides at 1.0e-02 m/s inside the cone (...)".
std::string sentence(const JudgedContact& contact);

/// Judgement of an impulse of any origin. `cone`, `cone_violation`, `siconos_map` and
/// JudgedContact::s are those of the impulse as given. Everything else is that of the impulse
/// projected on K_mu, as the criterion asks (data/manual/explanation/criterion.md).
struct ImpulseVerdict {
  ContactError error;
  /// max(epsilon, eta), in higher precision where rounding decides: accurate_guarded_error().
  double accurate = kNaN;
  /// Distance of the impulse as given from K_mu in the measure of eta, which does not see it:
  /// sqrt(Σ ½ W_nn |s - P_K(s)|² / max(D, theta E)). 0 inside; the result of a solver is inside.
  double cone = kNaN;
  /// ‖s - P_K(s - û)‖ / max(‖b‖, ‖s‖, ‖u‖) in the problem's variables, of the impulse as given: the
  /// stop test of Siconos Numerics 4.4. It depends on units, since it adds N s to m/s.
  double siconos_map = kNaN;
  double penetration_velocity = 0;  ///< largest -u_n, 0: nothing approaches              [m/s]
  int penetration_contact = -1;     ///< where
  double cone_violation = 0;        ///< largest |s - P_K(s)| of a contact                 [N s]
  int cone_contact = -1;
  ContactCount count;
  std::vector<JudgedContact> worst;  ///< from the worst down, only those with a fault
  Vector s;                          ///< projected, the problem's variables              [N s]
  Vector u;                          ///< W s + u_free, the problem's variables           [m/s]
  /// Why W is no Delassus operator, from a caller who accepts that; sentence() begins with it.
  std::string caution;

  /// max(accurate, cone), to be compared with a tolerance.
  double guarded() const;
};

/// Judges any impulse of a valid problem: s has m finite entries in the problem's variables. Names
/// at most `worst` contacts. They are ranked by their terms of epsilon or of eta², whichever of
/// epsilon and eta is larger. Throws std::invalid_argument for a wrong size, an entry that is not
/// finite, or an energy beyond double precision, or below it where impulses act.
ImpulseVerdict judge(const ContactProblem& problem, const Eigen::Ref<const Vector>& s,
                     int worst = 5);

/// The verdict in words: "within the tolerance 1e-8: error 3.1e-09", or "not within ...: ...; "
/// with the worst contact.
std::string sentence(const ImpulseVerdict& verdict, double tol);

}  // namespace bipot
