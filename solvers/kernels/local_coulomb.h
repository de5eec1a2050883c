#pragma once

#include "core/problem/coulomb_cone.h"

namespace bipot {

/// d x d block of W.
template <int D>
using LocalBlock = Eigen::Matrix<double, D, D, Eigen::DontAlign>;

/// The problem of a single contact, u = w s + q with the law (18) between u and s.
template <ContactRows D>
struct LocalProblem {
  LocalBlock<D> w;             ///< w(0, 0) > 0                                        [1/kg]
  Local<D> q;                  ///< velocity at s = 0                                   [m/s]
  FrictionOf<D> mu{};          ///< coefficients
  double step_normal = 0;      ///< 1/W_nn                                               [kg]
  double step_tangential = 0;  ///< 1/lambda_max(W_tt), 1/W_nn where W_tt vanishes   [kg]
  double step_rolling = 0;     ///< the same of the rolling rows, 0 where it vanishes      [kg m²]
  double step_spin = 0;        ///< likewise
};

/// Local problem of a diagonal block of W; q is not set.
template <ContactRows D>
LocalProblem<D> local_problem(const Eigen::MatrixXd& w, const FrictionOf<D>& mu);

/// The step of each row.
template <ContactRows D>
Local<D> steps_of(const LocalProblem<D>& p) {
  Local<D> steps = Local<D>::Constant(p.step_tangential);
  steps[0] = p.step_normal;
  if constexpr (D.rolls) {
    for (int k = 1 + D.tangents(); k < D; ++k) steps[k] = k == 5 ? p.step_spin : p.step_rolling;
  }
  return steps;
}

/// Improves s by `iterations` rounds of two half steps. First s_n <- max(0, s_n - omega u_n/W_nn),
/// with u_t updated. Then s_t <- s_t - omega u_t/lambda_max(W_tt), cut off at mu s_n. Each half
/// minimises (or majorises and minimises) along its coordinates. One round with omega = 1 is exact
/// for a diagonal block with equal tangents. Rolling and spin are two steps more. `u` is the
/// velocity at s. Inline: sweeps call it for every contact.
template <ContactRows D>
[[gnu::always_inline]] inline Local<D> improve_local(const LocalProblem<D>& p, Local<D> s,
                                                     Local<D> u, double omega, int iterations) {
  for (int k = 0; k < iterations; ++k) {
    const Local<D> before = s;
    s[0] = positive_part(s[0] - omega * p.step_normal * u[0]);
    if constexpr (D.rolls) {
      const Local<D> steps = steps_of<D>(p);
      each_bounded<D>(p.mu, [&](auto first, auto count, double bound) {
        const Local<D> at = u + p.w * (s - before);
        for (int a = first(); a < first() + count(); ++a) s[a] -= omega * steps[a] * at[a];
        const double norm = part_norm<first(), count()>(s), radius = bound * s[0];
        if (norm > radius) s.template segment<count()>(first()) *= radius / norm;
      });
    } else if constexpr (D > 1) {
      const double change = s[0] - before[0];
      for (int a = 1; a < D; ++a) {
        s[a] -= omega * p.step_tangential * (u[a] + p.w(a, 0) * change);
      }
      const double norm = tangential_norm<D>(s), radius = p.mu * s[0];
      if (norm > radius) s.template tail<D - 1>() *= radius / norm;
    }
    if (k + 1 < iterations) u += p.w * (s - before);
  }
  return s;
}

/// A solution, exact to rounding: take-off, then stick, then slip are tried. For d = 2 the slip
/// case is a formula, for d = 3 the one-dimensional root of
///
///     |x(λ)| = mu s_n(λ),   (S + λ I) x = -(q_t - w_tn q_n / w_nn),   S = W_tt - w_tn w_nt / w_nn
///
/// with u_t = -λ s_t: the sliding direction opposes the friction with an unknown factor λ > 0. The
/// root is bracketed by λ = 0 (stick has failed) and a bound on λ. It is found by Newton's method
/// on 1/|x| - 1/(mu s_n), with bisection as safeguard. [ours]; Bonnefon and Daviet (INRIA 2011)
/// solve the same equations as a quartic. Returns false, s unchanged, if the result violates the
/// law by more than 1e-9 relative (a block far from positive semidefinite). With rolling friction
/// rounds of improve_local() lead to the solution, at most 1000.
template <ContactRows D>
bool solve_local(const LocalProblem<D>& problem, Local<D>& s);

}  // namespace bipot
