#pragma once

#include <functional>

#include "solvers/homotopy/cell_basis.h"
#include "solvers/homotopy/law_point.h"

namespace bipot {

/// Follows the piecewise linear path of a proximal problem. With s and u the impulse and the
/// velocity of a point p of the law's manifold,
///
///     F(p) = u - W s - b - D (s - anchor) = (1 - t) r,    r = F(p at t = 0),
///
/// from t = 0 to t = 1, with D diagonal. In a cell F is B p - b + D anchor. The parameters move
/// along the line dp/dt = -x, x = B⁻¹ r, until one of them is zero. There the path enters the
/// neighbouring cell by the exchange of one column (a pivot); t may turn back. A generic path does
/// not end, closes, or ends on a ray (Eaves 1976).
///
/// Before a path that would cross many faces, Newton steps cross them all at once: to t = 1 of the
/// cell, then to the nearest point of the manifold, as long as |F| decreases.
class PathFollower {
 public:
  enum class End {
    kSolved,    ///< t = 1
    kRay,       ///< nothing blocks, or t fell without bound
    kLoop,      ///< back at the start, in the same direction
    kLong,      ///< more pivots than allowed
    kSingular,  ///< a cell whose matrix is singular to working precision
    kStopped,   ///< the caller's stop() said so
  };
  using enum End;
  /// Counts over all paths so far.
  struct Counts {
    int pivots = 0, turns = 0, paths = 0, failed = 0, newton = 0;
  };
  PathFollower(const LawProblem& problem, std::function<bool()> stop);

  /// Starts at `point`, which becomes the last point reached. `proximal`: the diagonal of D, m, >
  /// 0. `longest`: largest number of pivots.
  End follow(LawPoint& point, const Vector& anchor, const Vector& proximal, int longest);

  /// The turning point with the largest t of the last path, without its bounds; its t, 0 if there
  /// was none.
  double turning_t() const { return turning_t_; }
  const LawPoint& turning_point() const { return turning_point_; }
  const Counts& counts() const { return counts_; }

 private:
  struct Blocking {
    int slot = -1;
    double step = 0;
  };
  double residual(const LawPoint& point, Vector& f);
  End approach(LawPoint& point);
  End pursue(LawPoint& point, int longest);
  int refinements() const;
  bool refresh(LawPoint& point, bool move = true);
  template <class Visit>
  void for_nearer(const LawPoint& point, int but, const double& limit, const Visit& visit) const;
  Blocking blocking(const LawPoint& point, int last) const;
  void look_ahead(const LawPoint& point, const CellBasis::Candidate& now);
  bool pivot(LawPoint& point, int slot);
  void note_turn(const LawPoint& point);

  const LawProblem& problem_;
  std::function<bool()> stop_;
  CellBasis basis_;
  const Vector* proximal_ = nullptr;  // of the path in progress
  double least_proximal_ = 0;
  Vector target_;  // b - D anchor
  Vector r_, x_, y_, s_, u_;
  Vector x_factored_;      // x of the columns that were factored
  int since_refresh_ = 0;  // pivots
  bool factored_ = false;  // the basis is that of the point
  double t_ = 0;
  int direction_ = 1;  // of t
  double turning_t_ = 0;
  LawPoint turning_point_;
  std::vector<Blocking> nearest_;  // scratch of look_ahead()
  std::vector<CellBasis::Candidate> candidates_;
  Counts counts_;
};

}  // namespace bipot
