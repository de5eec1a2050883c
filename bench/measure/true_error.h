#pragma once

#include <optional>

#include "bench/measure/reference_solution.h"
#include "bench/measure/test_problem.h"
#include "core/problem/contact_error.h"
#include "core/types.h"

namespace bipot {

/// How wrong an impulse is in terms that a user feels. NaN where a measure is not defined.
struct TrueError {
  /// ‖v - v*‖_A / ‖v* - v_free‖_A, equal to sqrt(Δsᵀ W Δs / s*ᵀ W s*)             [-]
  double velocity = kNaN;
  /// Largest error of the resultant contact force on a body over the largest resultant; needs H
  /// with the rows of rigid bodies (see find_body_rows)                           [-]
  double force = kNaN;
  /// max |Δs_c| / max |s*_c|, only where W is regular, so that contact forces are unique  [-]
  double contact_force = kNaN;
  double penetration_velocity = kNaN;  ///< largest approach velocity left, physical    [m/s]
  double penetration = kNaN;  ///< overlap that it makes in a step over the smallest radius [-]
  double dissipated = kNaN;   ///< energy that contacts take out of the free motion     [J]
  double energy = kNaN;       ///< |dissipated - dissipated*| / |dissipated*|            [-]
};

/// Which rows of H are the forces on a body: those of `bodies` rigid bodies, each with its
/// translations first, then those of single translations (driven walls).
struct BodyRows {
  int bodies = 0, per_body = 0, translations = 0, walls = 0;
};
/// 2 rows a body for d = 1 (x, y), 3 for d = 2 (x, y, spin), 6 for d = 3. Nothing where the columns
/// of the normals do not have unit forces in these places, that is where H is of another kind.
std::optional<BodyRows> find_body_rows(const ContactProblem& problem);

/// Measures errors against one reference; the parts that do not depend on s are kept.
class TrueErrorEvaluator {
 public:
  TrueErrorEvaluator(const TestProblem& problem, const ReferenceSolution& reference);
  TrueError operator()(const Vector& s) const;

 private:
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
