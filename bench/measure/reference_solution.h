#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "bench/compare/comparison_target.h"
#include "core/problem/contact_error.h"
#include "core/types.h"
#include "solvers/solver.h"

namespace bipot {

/// What one solver reached on the way to a reference.
struct ReferenceAttempt {
  std::string solver;
  SolveStatus status = SolveStatus::kNotRun;
  double guarded = std::numeric_limits<double>::quiet_NaN();
  double seconds = 0;
};

/// The most accurate impulse that this build finds, and how far it can be trusted.
struct ReferenceSolution {
  std::string origin;  ///< of the problem, see ComparisonProblem
  int contacts = 0, dim = 0, dofs = 0;
  std::string solver;  ///< whose impulse it is
  Vector s;            ///< the problem's variables                              [N s]
  ContactError error;  ///< recomputed from s alone
  std::vector<ReferenceAttempt> attempts;
  /// Largest ‖v - v*‖_A / ‖v* - v_free‖_A between attempts that both stand below kTrusted; NaN with
  /// fewer than two of them.
  double velocity_spread = std::numeric_limits<double>::quiet_NaN();

  static constexpr double kTarget = 1e-12;  ///< guarded error that is asked for
  static constexpr double kTrusted = 1e-9;  ///< below it, differences are taken seriously
  static constexpr double kSeveral = 1e-5;  ///< relative difference of velocities
  static constexpr int kLarge = 1000;       ///< contacts: beyond, ten times the target is enough
};

/// What a time limit is counted in; CPU time does not depend on what else the machine does.
enum class LimitOn { kWall, kCpu };

/// Runs auto, newton, ipm and apgd in turn from s = 0 to a guarded error of `target`, each within
/// the time limit, until one gets there and a second one stands below 1e-9 (or ten times the
/// target, if that is more) as a witness; keeps the lowest. Beyond kLarge contacts the order is
/// auto, apgd, ipm, newton.
ReferenceSolution find_reference(const ComparisonProblem& problem, double time_limit,
                                 double target = ReferenceSolution::kTarget,
                                 LimitOn limit_on = LimitOn::kWall);

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
  TrueErrorEvaluator(const ComparisonProblem& problem, const ReferenceSolution& reference);
  TrueError operator()(const Vector& s) const;

 private:
  double dissipated(const Vector& s) const;
  double largest_resultant(const Vector& s) const;

  const ComparisonProblem& given_;
  const ReferenceSolution& reference_;
  mutable ContactErrorEvaluator evaluate_;  // scratch for velocities, W of a general A
  std::optional<BodyRows> body_rows_;
  bool unique_ = false;
  double reference_norm_ = 0, reference_force_ = 0, reference_impulse_ = 0;
  double reference_dissipated_ = 0;
};

/// A reference as a JSON file, bit for bit.
void write_reference(const std::filesystem::path& path, const std::string& problem,
                     const ReferenceSolution& reference);
/// Throws FileError.
ReferenceSolution read_reference(const std::filesystem::path& path);

}  // namespace bipot
