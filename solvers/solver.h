#pragma once

#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/execution.h"
#include "core/criterion/contact_error.h"
#include "core/problem/contact_problem.h"

namespace bipot {

class SolveRun;   // solvers/solve_run.h
struct AutoPlan;  // solvers/auto/plan.h

enum class SolveStatus {
  kNotRun,
  kConverged,    ///< the stop test holds; with the guarded test, confirmed by solve()
  kNothingToDo,  ///< no contacts, or s = 0 satisfies the law exactly
  kIterationLimit,
  kTimeLimit,
  kInterrupted,       ///< SolverOptions::cancelled said so
  kStalled,           ///< the iterate no longer changes, the tolerance is not met
  kDiverged,          ///< the iterate grows without bound or is not finite
  kNumericalFailure,  ///< a factorisation or a foreign library failed, or NaN was returned
  kInvalidInput
};
std::string_view to_string(SolveStatus status);
/// kConverged or kNothingToDo.
bool is_success(SolveStatus status);

/// The quantity compared with `tol`. kGuarded is the project's measure, max(epsilon, eta). kRaw42
/// is the paper's own (never met if undefined). kImpulse is the classical test ‖s^{i+1} - s^i‖ /
/// ‖s^{i+1}‖ between consecutive iterations.
enum class StopTest { kGuarded, kRaw42, kImpulse };
std::string_view to_string(StopTest stop);

/// One judged iteration.
struct IterationRecord {
  int iteration = 0;
  double seconds = 0;  ///< wall time since the solver began, criterion included
  ContactError error;
  double step = kNaN;  ///< solver's own, NaN if it has none
  /// Counts the contacts in each status, in a pass over them. Only while the record is passed;
  /// several processes all have to ask.
  std::function<ContactCount()> count;
};

/// Inputs common to all solvers, and the solver's own parameters by name.
struct SolverOptions {
  double tol = 1e-8;  ///< > 0
  StopTest stop = StopTest::kGuarded;
  int max_iterations = 1000000;   ///< >= 0
  int also_judged = 0;            ///< judged even if it is not due: this iteration or the next one
  double time_limit = kInfinity;  ///< wall seconds, > 0
  Vector s0;                      ///< start; empty: s = 0
  /// True: uncoupled parts of the problem are solved one by one (solvers/auto/islands.h). By
  /// default `auto` does so, the others do not. Only with the guarded test. Also a parameter:
  /// "islands".
  std::optional<bool> islands;
  Execution execution;  ///< threads and instructions: the result's bits do not depend on them
  std::map<std::string, std::string> parameters;  ///< e.g. {"omega", "1.6"}; see SolverEntry
  /// Of `auto`, read once for many solves; null: the parameter `plan` names its file.
  std::shared_ptr<const AutoPlan> plan;
  std::function<bool()> cancelled;  ///< polled at every iteration; true ends the solve, for Ctrl-C
  std::function<void(const IterationRecord&)> on_iteration;  ///< history, at the judged iterations
};

/// True if the error of one impulse meets options.stop. False for kImpulse, which needs two
/// impulses.
bool meets(const SolverOptions& options, const ContactError& error);

/// Start of a solve: options.s0, or 0 if that is empty. Size m.
Vector start_of(const ContactProblem& problem, const SolverOptions& options);
/// True if the start is not 0.
bool is_warm(const SolverOptions& options);

struct SolveResult {
  SolveStatus status = SolveStatus::kNotRun;
  std::string message = "solve() was not called";
  Vector s;            ///< m, admissible impulse (s ∈ K_mu), the problem's variables    [N s]
  Vector u;            ///< m, W s + u_free                                             [m/s]
  ContactError error;  ///< contact_error(problem, s); written by solve() only
  int iterations = 0;
  double setup_seconds = 0;  ///< wall time of factorisations and copies that do not depend on s
  double solve_seconds = 0;  ///< wall time of the iteration, criterion included
};

/// One parameter of a solver. A number or integer must lie in [minimum, maximum]. A choice must be
/// one of the words in `choices`, separated by '|'. The solver checks a text.
struct ParameterSpec {
  enum class Kind { kNumber, kInteger, kChoice, kText };
  struct Range {
    double minimum, maximum;
  };
  std::string_view name;
  Kind kind;
  std::string_view default_value;
  std::string_view choices = {};  ///< kChoice only
  double minimum = 0, maximum = 0;
  std::string_view help = {};
  std::string_view unit = {};  ///< numbers and integers; empty: a pure number

  static constexpr ParameterSpec number(std::string_view name, std::string_view value, Range range,
                                        std::string_view help, std::string_view unit = {}) {
    return {name, Kind::kNumber, value, {}, range.minimum, range.maximum, help, unit};
  }
  static constexpr ParameterSpec integer(std::string_view name, std::string_view value, Range range,
                                         std::string_view help, std::string_view unit = {}) {
    return {name, Kind::kInteger, value, {}, range.minimum, range.maximum, help, unit};
  }
  static constexpr ParameterSpec choice(std::string_view name, std::string_view value,
                                        std::string_view choices, std::string_view help) {
    return {name, Kind::kChoice, value, choices, 0, 0, help};
  }
  static constexpr ParameterSpec text(std::string_view name, std::string_view value,
                                      std::string_view help) {
    return {name, Kind::kText, value, {}, 0, 0, help};
  }
};

/// A parameter of every solver, through solve(): text for SolverOptions::islands. A solver with
/// this parameter of its own reads that option itself; for others solve() does.
inline constexpr ParameterSpec kIslandsParameter = ParameterSpec::choice(
    "islands", "on for auto, else off", "on|off",
    "solve parts that are not coupled one by one (any solver; guarded stop test)");

/// How a solver runs in parallel.
enum class Parallel {
  kNo,           ///< on the root process, which then has the whole problem
  kYes,          ///< on all; the iterates depend on the processes
  kReproducible  ///< on all; the iterates are those of any number of processes, except for sums
};
class Parameters;  // solvers/parameters.h

/// A row of the registry, or a solver of a caller.
struct SolverEntry {
  std::string_view name;
  std::string_view summary;  ///< one line with the citation
  std::function<void(SolveRun&)> run;
  std::span<const ParameterSpec> parameters = {};
  bool needs_delassus = false;  ///< W must be present; solve() assembles it if it is missing
  int max_dim = 3;              ///< largest contact dimension
  int max_contacts = std::numeric_limits<int>::max();  ///< beyond it: kInvalidInput, saying so
  bool rolls = false;                                  ///< takes rolling friction
  /// The iterates do not depend on `tol`, which only decides their end. A solve to a loose
  /// tolerance is then the beginning of one to a tight tolerance, for any stop test.
  bool path_ignores_tolerance = false;
  /// For these parameters; null: kNo.
  Parallel (*parallel)(const Parameters&) = nullptr;

  /// The same row with another solver.
  SolverEntry with(std::function<void(SolveRun&)> other) const {
    SolverEntry entry = *this;
    entry.run = std::move(other);
    return entry;
  }
};

/// Empty if the solver takes problems of this kind and size, else why not, as "solver X ...".
std::string beyond_solver(const SolverEntry& entry, const ContactProblem& problem);

/// A solver as a function from problem and options to its result: SolverEntry::run for solvers
/// whose iterates are not judged.
std::function<void(SolveRun&)> run_of(
    std::function<SolveResult(const ContactProblem&, const SolverOptions&)> solver);

}  // namespace bipot
