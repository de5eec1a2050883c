#pragma once

#include <memory>

#include "core/base/types.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// The shared criterion (data/manual/explanation/criterion.md), evaluated from a problem and an
/// impulse alone. s is projected on K_mu, and everything is in physical variables (row_scale taken
/// out). With u = W s / (1 + e) + b, û = u + mu |u_t| n, x⁻ = max(-x, 0) and sums over the
/// contacts:
///
///   G  = Σ [(mu s_n |u_t| + s_t·u_t)₊ + s_n |u_n|]          power that the law leaves unexplained
///   V  = Σ ½ (u_n⁻)² / W_nn                                 energy of the penetration velocity
///   D  = Σ mu s_n |u_t|                                     dissipation of friction
///   E  = max(½ sᵀ W s, Σ ½ (b_n⁻)² / W_nn)                  energy that the contacts move
///   η² = Σ ½ W_nn |s - P_K(s - û / W_nn)|² / max(D, θ E)    natural map, in energy
///
/// and ε = (G + V) / max(D, θ E). The term in ( )₊ is >= 0 on the cone except for rounding. A
/// numerator 0 gives 0; a positive one over 0 gives infinity. All are dimensionless, and NaN where
/// undefined. With rolling friction mu |u_t| stands for mu |u_t| + mu_r |w| + mu_spin |w_spin|, and
/// s_t·u_t has the moments too. Rolling rows are taken in the units of the others by a length of
/// each contact (rolling_arms()).
struct ContactError {
  double epsilon = kNaN;  ///< (G + V) / max(D, theta E): guarded form of (42)
  double eta = kNaN;      ///< natural map in energy, same denominator
  double raw42 = kNaN;    ///< (42) as printed: normal penetration clipped, NaN if D = 0
  /// ‖s - P_K(s - rho û)‖ / max(‖s‖, ‖rho b‖), rho = d / tr W_cc of each contact c.
  double natural_map = kNaN;
  int worst_epsilon = -1;        ///< contact with the largest term of G + V
  int worst_eta = -1;            ///< contact with the largest term of the natural map
  double friction_power = kNaN;  ///< D                                                        [J]
  double energy = kNaN;          ///< E: energy that the contacts move, or would have to move  [J]

  /// max(epsilon, eta): every solver stops on it and is judged by it.
  double guarded() const { return epsilon > eta || epsilon != epsilon ? epsilon : eta; }
};

/// θ: weight of E against D in the denominator (data/manual/explanation/criterion.md, "Why the
/// denominator").
inline constexpr double kTheta = 0.1;

/// Sums of the criterion over contacts, for every number type (contact_terms.h). The sums of a
/// whole are those of its uncoupled parts (W has no block between them).
template <class Real>
struct ErrorSumsOf {
  Real friction{};       ///< D                                                             [J]
  Real gap{};            ///< G                                                             [J]
  Real gap_clipped{};    ///< G with penetrating u_n set to 0, as in (42)               [J]
  Real penetration{};    ///< V                                                             [J]
  Real natural{};        ///< Σ ½ W_nn |s - P_K(s - û / W_nn)|²                             [J]
  Real moved{};          ///< sᵀ W s                                                        [J]
  Real natural_rel{};    ///< Σ |s - P_K(s - rho û)|²                                  [N² s²]
  Real impulse2{};       ///< Σ |s|²                                                   [N² s²]
  Real free_energy{};    ///< Σ ½ (b_n⁻)² / W_nn                                            [J]
  Real free_impulse2{};  ///< Σ |rho b|²                                               [N² s²]

  ErrorSumsOf& operator+=(const ErrorSumsOf& more) {
    friction += more.friction;
    gap += more.gap;
    gap_clipped += more.gap_clipped;
    penetration += more.penetration;
    natural += more.natural;
    moved += more.moved;
    natural_rel += more.natural_rel;
    impulse2 += more.impulse2;
    free_energy += more.free_energy;
    free_impulse2 += more.free_impulse2;
    return *this;
  }
  bool operator==(const ErrorSumsOf&) const requires std::is_same_v<Real, double>
  = default;
};
using ErrorSums = ErrorSumsOf<double>;

class DelassusOperator;  // core/problem/delassus.h
struct PieceSums;
struct ContactArrays;

/// The criterion of these sums; the worst contacts are unknown (-1).
ContactError error_of(const ErrorSums& sums);

/// How to judge a problem that is a part of a larger one: together with `others`, the sums of the
/// parts that are settled. Epsilon and eta are divided by `share`, the part of the tolerance that
/// may be used up by then. If `alone` > 0, the part's own error times `alone` counts where that is
/// smaller. The default judges the problem alone.
struct ErrorShare {
  ErrorSums others;
  double share = 1;  ///< in (0, 1]
  double alone = 0;

  bool operator==(const ErrorShare&) const = default;
};

/// The criterion of a part with these sums and this share; the worst contacts are left open (-1).
ContactError error_of(const ErrorSums& part, const ErrorShare& share);

/// Evaluates the criterion many times on one problem without allocation. s is projected on K_mu
/// first, as the paper asks, and velocities are recomputed from the projected s. Copies and
/// threads: as for DelassusOperator. Sums are taken in pieces (core/base/parallel.h), with the same
/// bits for any number of threads.
class ContactErrorEvaluator {
 public:
  explicit ContactErrorEvaluator(const ContactProblem& problem, int threads = 1,
                                 const ErrorShare& share = {});
  explicit ContactErrorEvaluator(ContactProblem&&, int = 1,
                                 const ErrorShare& = {}) = delete;  // would dangle
  /// Another evaluator for the problem of `made`, with its own share, at the cost of a copy of a
  /// DelassusOperator.
  ContactErrorEvaluator(const ContactErrorEvaluator& made, const ErrorShare& share);
  ContactErrorEvaluator(const ContactErrorEvaluator& made);
  ContactErrorEvaluator(ContactErrorEvaluator&&) noexcept;
  ~ContactErrorEvaluator();

  ContactError operator()(const Eigen::Ref<const Vector>& s);

  /// Projected impulse and its velocity of the last evaluation, in the problem's variables.
  const Vector& impulse() const { return s_; }
  const Vector& velocity() const { return u_; }
  const DelassusOperator& delassus() const { return *delassus_; }

  /// E of the impulse s = 0.
  double energy_at_rest() const;

  /// Releases the scratch memory, and with it impulse(), velocity() and part(), for callers that
  /// keep the evaluator while others use memory. The next evaluation allocates it again.
  void release_scratch();

  /// Sums of the problem, without the others of its share, and of one contact, at the last
  /// evaluation.
  const ErrorSums& sums() const { return sums_; }
  ErrorSums part(int contact) const;

 private:
  struct Prepared;
  // D: ContactRows, whose header is not installed.
  template <auto D, bool kScaled>
  ContactError evaluate(const Eigen::Ref<const Vector>& s);
  template <auto D, bool kScaled>
  void project(int begin, int end);
  template <auto D, bool kScaled>
  PieceSums sums(int begin, int end) const;
  ContactArrays arrays() const;

  const ContactProblem& problem_;
  int threads_;
  std::unique_ptr<DelassusOperator> delassus_;
  std::shared_ptr<const Prepared> prepared_;
  ErrorShare share_;
  ErrorSums sums_;
  Vector s_, u_;
};

/// One evaluation. Throws std::invalid_argument if s has not m rows.
ContactError contact_error(const ContactProblem& problem, const Eigen::Ref<const Vector>& s);

/// Number of contacts that take off (s_n = 0), stick (inside the cone) and slip or roll (on its
/// edge).
struct ContactCount {
  int take_off = 0, stick = 0, slip = 0;
};
ContactCount count_contacts(const ContactProblem& problem, const Eigen::Ref<const Vector>& s);

}  // namespace bipot
