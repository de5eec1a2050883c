#pragma once

#include <optional>

#include "bench/measure/reference_solution.h"
#include "bench/measure/test_problem.h"
#include "core/base/types.h"
#include "core/criterion/contact_error.h"
#include "core/problem/body_rows.h"

namespace bipot {

/// How wrong an impulse is in terms that a user feels. NaN where a measure is not defined. Of a
/// problem with several exact answers the one next to the impulse (in velocity) is v*, s* of the
/// differences; scales are those of the reference.
struct TrueError {
  /// ‖v - v*‖_A / ‖v* - v_free‖_A, equal to sqrt(Δsᵀ W Δs / s*ᵀ W s*)             [-]
  double velocity = kNaN;
  /// Largest error of the resultant contact force on a body over the largest resultant; needs H
  /// with the rows of rigid bodies (core/problem/body_rows.h)                           [-]
  double force = kNaN;
  /// max |Δs_c| / max |s*_c|, only where W is regular, so that contact forces are unique  [-]
  double contact_force = kNaN;
  double penetration_velocity = kNaN;  ///< largest approach velocity left, physical    [m/s]
  double penetration = kNaN;  ///< overlap that it makes in a step over the smallest radius [-]
  double dissipated = kNaN;   ///< energy that contacts take out of the free motion     [J]
  double energy = kNaN;       ///< |dissipated - dissipated*| / |dissipated*|            [-]
  int nearest = 0;  ///< answer that it was measured against: 0 the reference, k its others[k - 1]
};

/// Measures errors against one reference; the parts that do not depend on s are kept.
class TrueErrorEvaluator {
 public:
  TrueErrorEvaluator(const TestProblem& problem, const ReferenceSolution& reference);
  /// Against the nearest of the answers that the reference has when it is asked.
  TrueError operator()(const Vector& s) const;
  /// Largest differences between two of them.
  AnswerSpread spread() const;

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
