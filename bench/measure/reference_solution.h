#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "bench/measure/test_problem.h"
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
  std::string origin;  ///< of the problem, see TestProblem
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
/// auto, apgd, ipm, newton. `interrupted` is polled inside the solves: true ends the search.
ReferenceSolution find_reference(const TestProblem& problem, double time_limit,
                                 double target = ReferenceSolution::kTarget,
                                 LimitOn limit_on = LimitOn::kWall,
                                 const std::function<bool()>& interrupted = {});

/// A reference as a JSON file, bit for bit.
void write_reference(const std::filesystem::path& path, const std::string& problem,
                     const ReferenceSolution& reference);
/// Throws FileError.
ReferenceSolution read_reference(const std::filesystem::path& path);

}  // namespace bipot
