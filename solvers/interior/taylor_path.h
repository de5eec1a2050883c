#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "solvers/interior/interior_state.h"
#include "solvers/interior/series_weights.h"

namespace bipot {

enum class PathStep {
  kAdvanced,   ///< the state is a new point of the path
  kRetracted,  ///< the orientation was doubtful: the state returned to a shorter step
  kEnded,      ///< a factorisation failed, t grew without bound or no step is possible
};

/// A path of interior states, followed by Taylor series. Asymptotic numerical method: Damil and
/// Potier-Ferry, Int. J. Eng. Sci. 28, 1990; Cochelin, Damil and Potier-Ferry, Int. J. Numer.
/// Methods Eng. 37, 1994. Nguyen, Armand and Acary (2025) found that the central path of the exact
/// law is analytic and converges to a solution. It need not be monotone in its parameter, so that
/// it folds; they follow it by this method. From a state with products c and kinematic residual p0
/// the path is
///
///     X∘Y = t c,   u - U Y = t p0,   t from 1 to 0 (not monotonically).
///
/// X∘Y is bilinear for every d (contact_jordan.h) and the rest linear. Hence the series z = sum_k
/// alpha^k z_k needs one factorisation of the Newton matrix and one back-substitution for each
/// order:
///
///     L(z_0) z_k = (t_k c - sum_{0<j<k} X_j∘Y_{k-j}, t_k p0),
///     <z_k, z_1> + t_k t_1 / t² = [k = 1].
///
/// Here <.,.> is the mean over the pairs of the product of relative changes: alpha is an arclength
/// in them. The series is summed as a rational function (series_weights.h), or as it stands where
/// that is not better. The step is the longest one at which every product keeps a relative error of
/// 0.1. There is no corrector: products and residual of the end point define the path from there
/// on, and its weights drift by that tolerance. Any weights lead to a solution.
///
/// Orientation: the tangent continues that of the series before. The sign of det L changes exactly
/// if dt does (a fold), so that the two must agree. If they do not, the path may have been left:
/// the step is halved, up to six times, and then the tangent decides. At a bifurcation, which
/// symmetric scenes have, the determinant changes sign without a fold.
///
/// Resumable: between calls of advance() the system may serve others; the path's state is in here.
template <ContactRows D>
class TaylorPath {
 public:
  using Jordan = ContactJordan<D>;
  using Pairs = typename Jordan::Pairs;
  static constexpr int P = Jordan::P;

  /// Keeps a reference to the system. `order` of the series, at least 2.
  TaylorPath(InteriorSystem<D>& system, InteriorState<D> start, int order = 15);

  /// One factorisation, one series. After kEnded it has no effect.
  PathStep advance();

  const InteriorState<D>& state() const { return z_; }
  double t() const { return t_now_; }
  bool descending() const { return orientation_ < 0; }  ///< the last series went towards t = 0
  bool ended() const { return ended_; }
  int series() const { return num_series_; }
  int folds() const { return folds_; }  ///< changes of the direction of t

  /// Arclength of the last series' step, and the point of that series at `alpha`.
  double reach() const { return reach_; }
  struct Point {
    Vector X, Y;
    double t = 0;
  };
  Point point(double alpha) const;

 private:
  using Coefficients = Eigen::Matrix<double, P, Eigen::Dynamic>;

  PathStep end();
  bool orient(int determinant, const PairDirection& tangent);
  void retract();
  bool expand(double dt, const PairDirection& tangent);
  bool find_reach();
  bool grow();
  std::pair<Pairs, Pairs> relative_term(int c, int k) const;
  Eigen::MatrixXd sample() const;
  bool accurate(double alpha) const;
  void take(double alpha);
  double metric(const PairDirection& a, const PairDirection& b) const;
  /// Those of one contact in X_ or Y_.
  template <class Values>
  auto coefficients(Values& x, int c) const {
    using Matrix = std::conditional_t<std::is_const_v<Values>, const Coefficients, Coefficients>;
    return Eigen::Map<Matrix>(&x[to_size(c) * to_size(P * (order_ + 1))], P, order_ + 1);
  }
  void store(int order, const PairDirection& d, double dt, const PairDirection& tangent);

  InteriorSystem<D>& system_;
  int order_;
  InteriorState<D> z_;
  double t_now_ = 1;
  Vector c_;                   // products of the point of which the series is, over its t
  std::vector<double> X_, Y_;  // P x (order + 1) coefficients of each contact, columns contiguous
  Vector t_;                   // coefficients of t
  SeriesWeights weights_;      // of the last series
  PairDirection end_tangent_;  // derivative of the last series at its end
  double end_dt_ = 0;
  double reach_ = 0;
  int reference_sign_ = 0;  // of the determinant where t falls
  int orientation_ = -1;
  int num_series_ = 0, folds_ = 0;
  int retractions_here_ = 0;
  bool ended_ = false;

  PairDirection tangent_, next_;  // scratch of advance()
  Vector r_, covector_x_, covector_y_;
};

}  // namespace bipot
