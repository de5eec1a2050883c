#pragma once

#include "core/criterion/contact_error.h"
#include "core/criterion/rounded.h"

namespace bipot {

/// A bound on the effect of rounding on the criterion of contact_error.h.
struct RoundingBound {
  double epsilon = 0;  ///< |computed - exact|  [-]
  double eta = 0;

  /// The same for max(ε, η): the difference of two maxima is at most the larger difference.
  double guarded() const { return epsilon > eta || epsilon != epsilon ? epsilon : eta; }
};

/// About the smallest guarded error that an impulse near s can have in double precision: rounding s
/// alone leaves υ Σ s_n (|W| |s|)_n of G, with υ = 2^-53, over max(D, θ E) of `error`. Solvers may
/// come some ten times lower. 0 without W and with a general A. Cost: two passes through H, or one
/// through W.
double rounding_floor(const ContactProblem& problem, const Eigen::Ref<const Vector>& s,
                      const ContactError& error);

enum class Precision {
  kDouble,    ///< ContactErrorEvaluator, unit roundoff 2^-53
  kExtended,  ///< extended_guarded_error(), unit roundoff 2^-64
  kQuadruple  ///< quadruple_guarded_error(), unit roundoff 2^-113
};

/// Running error analysis of one evaluation (Higham, Accuracy and Stability of Numerical
/// Algorithms, §3). Every sum of n products is off by at most n unit roundoffs times the sum of the
/// absolute values. These bounds go through the formulas of the criterion (rounded.h), and the
/// result is taken times 1.01. The bound covers the projection of s on the cones, velocities by
/// either form of the operator, and weights; it does not depend on the order of summation. With
/// share.alone the smaller of two figures counts, and the bound says how much larger the exact one
/// may be.
///
/// Limits: no underflow or overflow, which solve() scales away; s on the cone to rounding. Infinite
/// where the denominator is rounding alone. Cost: two passes through H, or one through W.
RoundingBound rounding_bound(const ContactProblem& problem, const Eigen::Ref<const Vector>& s,
                             Precision precision, const ErrorShare& share = {});

// The same in three steps, for a problem of which no process has the whole (solvers/parallel):
// momenta of the bodies, sums over the contacts, bound. A must be diagonal.

/// H s in n degrees of freedom, with the size and number of its summands.
struct RoundedMomentum {
  Vector momentum;  ///< Σ H s                                                             [N s]
  Vector size;      ///< Σ |H s|
  Vector count;     ///< summands
};
RoundedMomentum rounded_momentum(const ContactProblem& problem, const Eigen::Ref<const Vector>& s);

/// Sums of the criterion over contacts with their errors in double precision. That of `natural` is
/// Σ ½ W_nn |error of N|², the square of a norm. The sums of parts add up.
using RoundedSums = ErrorSumsOf<Rounded>;
/// Sums over all contacts of a problem. Errors are infinite if it has neither W nor a diagonal A.
/// The same bits for any number of threads.
RoundedSums rounded_sums(const ContactProblem& problem, const Eigen::Ref<const Vector>& s,
                         int threads = 1);
/// The same with given momenta of its degrees of freedom.
RoundedSums rounded_sums(const ContactProblem& problem, const Eigen::Ref<const Vector>& s,
                         const RoundedMomentum& pushed, int threads = 1);
/// `contacts`: number of summands. In a higher precision the errors are those in double, scaled.
RoundingBound rounding_bound(const RoundedSums& sums, int contacts, Precision precision,
                             const ErrorShare& share = {});

}  // namespace bipot
