#pragma once

#include <optional>

#include "bench/measure/reference_solution.h"
#include "bench/measure/test_problem.h"
#include "core/base/types.h"
#include "core/criterion/contact_error.h"
#include "core/problem/body_rows.h"

namespace bipot {

/// Error of an impulse in physical quantities. Undefined measures are NaN. v* and s* are the exact
/// answer nearest to the impulse (in velocity); scales are those of the reference.
struct TrueError {
  /// ‖v - v*‖_A / ‖v* - v_free‖_A, equal to sqrt(Δsᵀ W Δs / s*ᵀ W s*)             [-]
  double velocity = kNaN;
  /// Largest error of the resultant contact force on a body over the largest resultant; needs H
  /// with the rows of rigid bodies (core/problem/body_rows.h) [-]
  double force = kNaN;
  /// max |Δs_c| / max |s*_c|, only if W is regular, so that contact forces are unique [-]
  double contact_force = kNaN;
  double penetration_velocity = kNaN;  ///< largest approach velocity left, physical    [m/s]
  double penetration = kNaN;  ///< overlap that it causes in a step over the smallest radius [-]
  double dissipated = kNaN;   ///< energy that contacts take from the free motion     [J]
  double energy = kNaN;       ///< |dissipated - dissipated*| / |dissipated*|            [-]
  int nearest = 0;  ///< index of the answer compared with: 0 the reference, k its others[k - 1]
};

/// Computes errors against one reference; parts that do not depend on s are kept.
class TrueErrorEvaluator {
 public:
  TrueErrorEvaluator(const TestProblem& problem, const ReferenceSolution& reference);
  /// Error against the nearest of the reference's present answers.
  TrueError operator()(const Vector& s) const;
  /// Largest differences between two of the answers.
  ReferenceSolution::Spread spread() const;

 private:
  TrueError difference(const Vector& s, const Vector& exact) const;
  double distance(const Vector& a, const Vector& b) const;
  double dissipated(const Vector& s) const;
  double largest_resultant(const Vector& s) const;

  const TestProblem& given_;
  const ReferenceSolution& reference_;
  mutable ContactErrorEvaluator evaluate_;  // scratch for velocities, W of a general A
  std::optional<BodyRows> body_rows_;
  bool unique_ = false;
  double reference_norm_ = 0, reference_force_ = 0, reference_impulse_ = 0;
  double reference_dissipated_ = 0;
};

}  // namespace bipot
