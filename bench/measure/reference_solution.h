#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "bench/measure/test_problem.h"
#include "core/base/types.h"
#include "core/criterion/contact_error.h"
#include "solvers/analysis/distinct_answers.h"
#include "solvers/solver.h"

namespace bipot {

/// What one solver reached on the way to a reference.
struct ReferenceAttempt {
  std::string solver;
  SolveStatus status = SolveStatus::kNotRun;
  double guarded = std::numeric_limits<double>::quiet_NaN();
  double seconds = 0;
};

/// Largest differences between two exact answers of one problem; NaN with a single one, or where a
/// measure is not defined. Scales as in TrueError.
struct AnswerSpread {
  double velocity = kNaN, force = kNaN, energy = kNaN;
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
  /// Exact answers that are distinct from s and from each other (solvers/analysis/distinct_answers.h), in the
  /// order in which they were found: their being there proves that the problem has several.
  std::vector<Vector> others;
  AnswerSpread spread;  ///< between s and the others

  bool several() const { return !others.empty(); }

  static constexpr double kTarget = 1e-12;  ///< guarded error that is asked for
  /// Below it, differences are taken seriously.
  static constexpr double kTrusted = DistinctAnswers::kTrusted;
  static constexpr int kLarge = 1000;  ///< contacts: beyond, ten times the target is enough
};

/// What a time limit is counted in; CPU time does not depend on what else the machine does.
enum class LimitOn { kWall, kCpu };

/// Runs auto, newton, ipm and apgd in turn from s = 0 to a guarded error of `target`, each within
/// the time limit, until one gets there and a second one stands below 1e-9 (or ten times the
/// target, if that is more) as a witness; keeps the lowest, and what is distinct from it besides.
/// Beyond kLarge contacts the order is auto, apgd, ipm, newton. `interrupted` is polled inside the solves: true ends the search.
ReferenceSolution find_reference(const TestProblem& problem, double time_limit,
                                 double target = ReferenceSolution::kTarget,
                                 LimitOn limit_on = LimitOn::kWall,
                                 const std::function<bool()>& interrupted = {});

/// Adds an impulse to the reference's others where it is an exact answer that is not among them.
/// One that is nearly exact (guarded error at most 1e-6) and far from all of them is first solved on
/// from where it is, within the time limit (CPU). True: it was added, and the spread is stale.
bool learn_answer(const ContactProblem& problem, const Vector& s, double time_limit,
                  const std::function<bool()>& interrupted, ReferenceSolution& reference);

/// A reference as a JSON file, bit for bit.
void write_reference(const std::filesystem::path& path, const std::string& problem,
                     const ReferenceSolution& reference);
/// Throws FileError.
ReferenceSolution read_reference(const std::filesystem::path& path);

}  // namespace bipot
