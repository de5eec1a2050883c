#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/stopwatch.h"
#include "core/linear/system_factor.h"
#include "solvers/contact_space.h"
#include "solvers/parameters.h"
#include "solvers/solver.h"
#include "solvers/stop_rule.h"

namespace bipot {

/// One run of a solver: its space, options and parameters, the clock, and the judge that decides
/// when to stop. In parallel all processes stop at the same iteration: time and interruption are
/// checked with every judgement and every kPolled iterations.
///
/// Cadence: an iterate is judged when the count k has grown by its root (which minimises the cost
/// of evaluations and iterations) or, from k = 1024 on, by 1/32. The reported count is then exact
/// to 1/root k, later to 3 %. Solvers whose iteration is a factorisation have every iterate judged.
/// `assor` has one in 16 judged at last; before, on streamed packings, the interval is three roots,
/// and with deflation one in six. The impulse test compares consecutive iterates; it is evaluated
/// at every iteration.
///
/// The run keeps the best iterate by the guarded error; a solve that stops early returns it.
class SolveRun {
 public:
  /// Keeps references. Time counts from construction.
  SolveRun(ContactSpace& space, const SolverEntry& entry, const SolverOptions& options);
  /// For a solver outside the table, on a problem of one process.
  SolveRun(const ContactProblem& problem, const SolverOptions& options);
  SolveRun(ContactProblem&&, const SolverOptions&) = delete;  // would dangle
  SolveRun(const SolveRun&) = delete;
  SolveRun& operator=(const SolveRun&) = delete;

  ContactSpace& space() { return space_; }
  /// The contacts of this process.
  const ContactProblem& problem() const { return space_.problem(); }
  const SolverEntry& entry() const { return entry_; }
  const SolverOptions& options() const { return options_; }
  const Parameters& parameters() const { return parameters_; }
  /// options.s0, or 0, in the rows of this process.
  Vector start() const { return start_of(problem(), options_); }

  // If one process has the whole problem:
  WholeSpace& whole() { return *space_.whole(); }
  const DelassusOperator& delassus() { return whole().delassus(); }
  /// Factors the run's linear systems in parallel; null: this process factors alone.
  SystemFactor* factor() {
    factor_asked_ = true;
    return factor_;
  }
  /// Ends factorisations when out_of_time() would; finish() then tells why.
  FactorStop factor_stop() {
    return FactorStop([this] { return cancelled_here() || late_here(); });
  }
  void set_factor(SystemFactor* factor) { factor_ = factor; }
  bool factor_was_asked() const { return factor_asked_; }

  /// For solvers whose iteration is a factorisation or more: every one is judged, whatever the
  /// count, so that every stage sees its errors.
  void judge_every_iteration() { every_ = true; }
  /// Half as often as others: few iterations, each cheaper than judging it. `much_cheaper`: as for
  /// both streaming through memory, the iteration once for several sweeps; a third as often before.
  void judge_half_as_often(bool much_cheaper = false) {
    portion_ = kJudgedPortion / 2;
    roots_ = much_cheaper ? 3 : 1;
  }

  /// The next iterate is judged, whatever the cadence.
  void judge_next() { next_ = 0; }

  /// True if this iteration is judged; so is the last one of a solve that the caller or the clock
  /// ends. Ask first if forming s costs work.
  bool due(int iteration);

  /// Number of iterations from `iteration` on to the next judged one, 1 to `most`: a solver may do
  /// these without asking. A caller's Ctrl-C and the time limit wait for them.
  int undue(int iteration, int most) const;

  /// Call after every iteration (iteration = number of completed iterations). True: stop now. No
  /// effect unless due(iteration). `step` goes into the history. `moving`: a state of the solver
  /// beside s (multipliers) still changes, so that an equal s is no stall.
  bool stop(int iteration, const Eigen::Ref<const Vector>& s, double step = kNaN,
            bool moving = false);

  /// For solvers that detect their end themselves, successful or not.
  void end(SolveStatus status, std::string message);

  /// Ends the solve if the caller asked for it (kInterrupted) or the time is over (kTimeLimit);
  /// true: stop now. For work outside of stop(), such as an inner solver that has returned.
  bool end_if_out_of_time(int iteration);

  /// Judges s now, whatever the cadence, without stopping: true if it meets the stop test.
  bool meets(const Eigen::Ref<const Vector>& s);

  /// Guarded error of the last judged iterate and of the best one.
  double last_error() const { return last_.guarded(); }
  double best_error() const { return best_error_; }
  const Vector& best_impulse();
  SolveStatus status() const { return status_; }

  double seconds() const { return watch_.seconds(); }
  bool cancelled();    ///< the caller asked to stop
  bool late();         ///< the time limit is reached
  bool out_of_time();  ///< either of them, for loops within an iteration
  /// Time limit of an inner solver: what is left, > 0.
  double remaining_seconds() const;
  /// Ends the set-up phase: seconds so far become setup_seconds.
  void end_setup() { setup_seconds_ = seconds(); }

  /// For solvers whose count differs from that of stop().
  void set_iterations(int iterations) { iterations_ = iterations; }
  /// Adds text to the message of the result.
  void remark(const std::string& text) { remarks_ += text; }
  /// For solvers with a result from elsewhere: it becomes that of the run.
  void take(SolveResult result) { taken_ = std::move(result); }

  /// Another solver on the same problem, from options.s0, without the last judgement of solve(). In
  /// parallel a solver for one process runs on the root process. `share`: part of the tolerance
  /// that this problem may use as a part of a larger one.
  SolveResult nested(const SolverEntry& entry, const SolverOptions& options,
                     const ErrorShare& share = {});
  /// The same for a row of the table with default parameters; it ends with the run.
  SolveResult nested(std::string_view solver, double tol, int max_iterations, Vector s0);

  /// The solver, until it ends. A factorisation that was stopped or lacks memory ends it, too.
  void perform();
  /// Status, message, iterations, timings and the impulse: the last one if it converged, else the
  /// best.
  SolveResult finish();

 private:
  static constexpr int kPolled = 64;

  bool accept(double impulse_change);
  bool at_floor(int iteration);
  void replace_previous(const Eigen::Ref<const Vector>& s, bool known, double& norm2,
                        double& change2);
  bool cancelled_here() const { return options_.cancelled && options_.cancelled(); }
  bool late_here() const {
    return options_.time_limit < kInfinity && seconds() >= options_.time_limit;
  }
  ContactCount count();

  std::unique_ptr<WholeSpace> own_space_;  // of a run that has made it
  ContactSpace& space_;
  const SolverEntry& entry_;
  const SolverOptions& options_;
  const Parameters parameters_;
  const Stopwatch watch_;
  SystemFactor* factor_ = nullptr;
  bool factor_asked_ = false;
  double setup_seconds_ = 0;
  ContactError last_;
  double best_error_ = kInfinity;
  Vector best_s_;
  Vector previous_;  // iterate of the judgement before (all iterations for the impulse test)
  int previous_iteration_ = -1;
  int next_ = 0, next_poll_ = 0, next_floor_ = 16;
  bool every_ = false;
  int portion_ = kJudgedPortion, roots_ = 1;
  int iterations_ = 0;
  double free_energy_;
  SolveStatus status_ = SolveStatus::kNotRun;
  std::string message_, remarks_;
  std::optional<SolveResult> taken_;
};

/// A whole run of `entry`: solve() without its refusals and its last judgement. In the given space,
/// whose last judgement it replaces; for another share of the whole in one made from it.
SolveResult run_solver(const SolverEntry& entry, ContactSpace& space, const SolverOptions& options,
                       const ErrorShare& share = {}, SystemFactor* factor = nullptr);
SolveResult run_solver(const SolverEntry& entry, const ContactProblem& problem,
                       const SolverOptions& options);

/// on_iteration for a part of a solve with these options, which must live: of a part that begins
/// after so many iterations and seconds. `with_start`: its iteration 0 is passed on, too.
std::function<void(const IterationRecord&)> history_after(const SolverOptions& options,
                                                          int iterations, double seconds,
                                                          bool with_start);

/// How the entry runs with these options in parallel. Throws for unknown parameters.
Parallel runs_on_parts(const SolverEntry& entry, const SolverOptions& options);

// The parts of solve() (solve.h), for callers who make the space:

/// Why solve() refuses, in a sentence; empty where it does not. `problem`: the contacts that are
/// here.
std::string refusal(const SolverEntry& entry, const ContactProblem& problem,
                    const SolverOptions& options);
/// All but the refusals. `watch`: runs since the set-up began. Collective.
SolveResult solve_in(ContactSpace& space, const SolverEntry& entry, const SolverOptions& options,
                     const Stopwatch& watch);

/// For callers who continue after a failure: rethrows it unless all processes know of it.
void require_common(ContactSpace& space, const std::exception& failure);

}  // namespace bipot
