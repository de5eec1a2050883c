#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/measure/problem_mark.h"
#include "bench/measure/test_problem.h"
#include "bench/report/json_output.h"
#include "core/base/types.h"
#include "core/criterion/contact_error.h"
#include "solvers/analysis/distinct_answers.h"
#include "solvers/solver.h"

namespace bipot {

/// The most accurate impulse found, and its reliability.
struct ReferenceSolution {
  /// Largest differences between two exact answers of one problem; NaN for a single one, or if a
  /// measure is not defined. Scales as in TrueError.
  struct Spread {
    double velocity = kNaN, force = kNaN, energy = kNaN;
  };
  /// Result of one solver in the search for a reference.
  struct Attempt {
    std::string solver;
    SolveStatus status = SolveStatus::kNotRun;
    double guarded = kNaN;
    double seconds = 0;
  };
  std::string origin;  ///< of the problem, see TestProblem
  int contacts = 0, dim = 0, dofs = 0;
  ProblemMark mark;    ///< of the problem
  std::string solver;  ///< whose impulse it is
  Vector s;            ///< the problem's variables                              [N s]
  ContactError error;  ///< recomputed from s alone
  std::vector<Attempt> attempts;
  /// Largest ‖v - v*‖_A / ‖v* - v_free‖_A between attempts that are both below kTrusted; NaN with
  /// fewer than two of them.
  double velocity_spread = kNaN;
  /// Exact answers distinct from s and from each other (solvers/analysis/distinct_answers.h), in
  /// the order in which they were found. They prove that the problem has several.
  std::vector<Vector> others;
  Spread spread;  ///< between s and the others

  bool several() const { return !others.empty(); }

  static constexpr double kTarget = 1e-12;  ///< guarded error that is asked for
  /// Below it, differences count.
  static constexpr double kTrusted = DistinctAnswers::kTrusted;
  static constexpr int kLarge = 1000;  ///< contacts: beyond, ten times the target is enough
};

/// Runs auto, newton, ipm and apgd from s = 0 to a guarded error of `target`, each within the limit
/// of CPU time. It ends once one reaches the target and a second one is below 1e-9 (or ten times
/// the target, if that is more) as a witness. Keeps the lowest, and distinct answers besides.
/// Beyond kLarge contacts the order is auto, apgd, ipm, newton. `interrupted` is polled inside the
/// solves: true ends the search.
ReferenceSolution find_reference(const TestProblem& problem, double time_limit,
                                 double target = ReferenceSolution::kTarget,
                                 const std::function<bool()>& interrupted = {});

/// Adds an impulse to the reference's others if it is a new exact answer. A nearly exact one
/// (guarded error at most 1e-6), far from all of them, is first improved within the time limit
/// (CPU). True: it was added, and the spread is outdated.
bool learn_answer(const ContactProblem& problem, const Vector& s, double time_limit,
                  const std::function<bool()>& interrupted, ReferenceSolution& reference);

Json to_json(const ReferenceSolution::Spread& spread);
Json to_json(const ReferenceSolution::Attempt& attempt);

/// A reference as a JSON file, bit for bit.
void write_reference(const std::filesystem::path& path, const std::string& problem,
                     const ReferenceSolution& reference);
/// Throws FileError.
ReferenceSolution read_reference(const std::filesystem::path& path);

}  // namespace bipot
