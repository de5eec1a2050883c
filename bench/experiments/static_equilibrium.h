#pragma once

#include <functional>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Decides whether impulses exist that hold everything at rest: s in K_mu with A v_free + H s = 0.
/// This is a question of limit analysis and has one answer. The contact law itself (not associated)
/// may admit motion beside rest.
struct StaticEquilibrium {
  /// ‖v‖/‖v_free‖ in the energy norm of A, for the velocity nearest to rest that impulses in K_mu
  /// can reach: min ‖v_free + A⁻¹ H s‖_A. Zero (to round-off) if equilibrium exists.
  double motion = 0;
  bool exists = false;  ///< motion <= kRest
  /// If `exists`: the impulse that holds, in the problem's rows, on the edges of the cone only if
  /// it must be.
  Vector s;
  /// The nearest velocity. If equilibrium does not exist it proves that: Hᵀ v lies in the dual cone
  /// (u_n >= mu |u_t|) and the load does work, v·A v_free = ‖v‖² > 0. Hence no s in K_mu balances
  /// the load (Farkas).
  Vector v;
  double dual_violation = 0;  ///< of u_n - mu |u_t| >= 0, relative to the largest |v_free|

  static constexpr double kRest = 1e-9;
};

/// For a problem with d = 2, H and no row_scale. In 2D K_mu is spanned by its two edges. The
/// nearest velocity therefore solves a frictionless problem of twice the contacts whose normals are
/// the edges; the interior-point solver takes it to 1e-11. Throws std::invalid_argument for another
/// form, std::runtime_error if the solver fails.
StaticEquilibrium static_equilibrium(const ContactProblem& problem);

/// The least mu in [low, high], to a relative width of `accuracy`, from which the problem of
/// `with_friction(mu)` has a static equilibrium; existence is monotone in mu. NaN if there is none
/// at `high`; `low` if there is one at `low`.
double critical_friction(const std::function<ContactProblem(double)>& with_friction, double low,
                         double high, double accuracy = 1e-7);

}  // namespace bipot
