#pragma once

#include "core/problem/contact_problem.h"
#include "core/problem/delassus.h"
#include "core/types.h"

namespace bipot {

/// The shared criterion (data/criterion.md), evaluated from a problem and an impulse alone. With s
/// projected on K_mu, u = W s / (1 + e) + b, û = u + mu |u_t| n, x⁻ = max(-x, 0), sums over the
/// contacts and everything in physical variables (row_scale taken out):
///
///   G  = Σ [(mu s_n |u_t| + s_t·u_t)₊ + s_n |u_n|]          power that the law leaves unexplained
///   V  = Σ ½ (u_n⁻)² / W_nn                                 energy of the penetration velocity
///   D  = Σ mu s_n |u_t|                                     dissipation of friction
///   E  = max(½ sᵀ W s, Σ ½ (b_n⁻)² / W_nn)                  energy that the contacts move
///   η² = Σ ½ W_nn |s - P_K(s - û / W_nn)|² / max(D, θ E)    natural map, in energy
///
/// and ε = (G + V) / max(D, θ E). What stands in ( )₊ is >= 0 on the cone but for rounding. A
/// numerator 0 gives 0, a positive one over 0 infinity. All dimensionless; NaN where undefined.
struct ContactError {
  double epsilon = kNaN;  ///< (G + V) / max(D, theta E): guarded form of (42)
  double eta = kNaN;      ///< natural map in energy, same denominator
  double raw42 = kNaN;    ///< (42) as printed: normal penetration clipped, NaN where D = 0
  /// ‖s - P_K(s - rho û)‖ / max(‖s‖, ‖rho b‖), rho = d / tr W_cc of each contact c.
  double natural_map = kNaN;
  int worst_epsilon = -1;        ///< contact with the largest term of G + V
  int worst_eta = -1;            ///< contact with the largest term of the natural map
  double friction_power = kNaN;  ///< D                                                        [J]
  double energy = kNaN;          ///< E: energy that the contacts move, or would have to move  [J]

  /// max(epsilon, eta): what every solver stops on and is judged by.
  double guarded() const { return epsilon > eta || epsilon != epsilon ? epsilon : eta; }
};

/// θ: weight of E against D in the denominator (data/criterion.md, "Why the denominator").
inline constexpr double kTheta = 0.1;

/// Evaluates the criterion many times on one problem without allocation. s is projected on K_mu
/// first (the paper asks for it), velocities are recomputed from the projected s. Where the problem
/// carries a row_scale, everything is measured in physical variables. Copies and threads: as for
/// DelassusOperator; sums are taken in pieces (core/parallel.h), with the same bits for any number
/// of threads.
class ContactErrorEvaluator {
 public:
  explicit ContactErrorEvaluator(const ContactProblem& problem, int threads = 1);
  explicit ContactErrorEvaluator(ContactProblem&&, int = 1) = delete;  // would dangle

  ContactError operator()(const Eigen::Ref<const Vector>& s);

  /// Projected impulse and its velocity of the last evaluation, in the problem's variables.
  const Vector& impulse() const { return s_; }
  const Vector& velocity() const { return u_; }
  const DelassusOperator& delassus() const { return delassus_; }

 private:
  struct Sums;
  template <int D, bool kScaled>
  ContactError evaluate();
  template <int D, bool kScaled>
  void project(int begin, int end);
  template <int D, bool kScaled>
  Sums sums(int begin, int end) const;

  const ContactProblem& problem_;
  int threads_;
  DelassusOperator delassus_;
  Vector w_nn_;             // c, physical W_nn
  Vector rho_nn_;           // c, 1/W_nn
  Vector rho_nat_;          // c, d / trace of the physical diagonal block
  double free_energy_ = 0;  // ½ Σ rho_c (b_n⁻)², physical
  double free_norm_ = 0;    // ‖rho u_free‖, physical
  Vector s_, u_;
};

/// One evaluation.
ContactError contact_error(const ContactProblem& problem, const Eigen::Ref<const Vector>& s);

/// How many contacts take off (s_n = 0), stick (inside the cone) and slip (on its edge).
struct ContactCount {
  int take_off = 0, stick = 0, slip = 0;
};
ContactCount count_contacts(const ContactProblem& problem, const Eigen::Ref<const Vector>& s);

}  // namespace bipot
