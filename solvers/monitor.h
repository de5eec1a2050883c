#pragma once

#include "core/base/stopwatch.h"
#include "core/criterion/contact_error.h"
#include "solvers/solver.h"
#include "solvers/stop_rule.h"

namespace bipot {

/// Judges the iterates of every solver in the same way, and decides when to stop.
///
/// Cadence: whenever the count k has grown by its root (the least that evaluations and iterations cost
/// together) or, from k = 1024 on, by 1/32: the reported count is exact to 1/root k, then to 3 %;
/// solvers whose iteration is a factorisation have every one judged, `assor` one in 16 at last, where it
/// streams through memory by three roots, 3/root k, before, and one in six where it takes stresses out.
/// The impulse test compares consecutive iterates and is therefore evaluated at every iteration.
///
/// The monitor keeps the best iterate by the guarded error; a solve that stops early returns it.
class IterationMonitor {
 public:
  /// `watch`: runs since the set-up began, for solvers that must work before they can have a
  /// monitor.
  IterationMonitor(const ContactProblem& problem, const SolverOptions& options,
                   const Stopwatch& watch = {});

  /// For solvers whose iteration is a factorisation or more: every one is judged, whatever the
  /// count, so that no stage of theirs is blind.
  void judge_every_iteration() { every_ = true; }
  /// Half as often as others: few iterations, each cheaper than judging it. `much_cheaper`: as where
  /// both stream through memory, the iteration once for several sweeps; a third as often before.
  void judge_half_as_often(bool much_cheaper = false) {
    portion_ = kJudgedPortion / 2;
    roots_ = much_cheaper ? 3 : 1;
  }

  /// The next iterate is judged, whatever the cadence.
  void judge_next() { next_ = 0; }

  /// Whether this iteration is judged; so is the one at which the caller or the clock ends the
  /// solve. A solver that must do work to form s asks first.
  bool due(int iteration) const;

  /// Iterations from `iteration` on to the next one that is judged, 1 to `most`: a solver may do so
  /// many before it asks again. A caller's Ctrl-C and the time limit wait for them.
  int undue(int iteration, int most) const;

  /// Call after every iteration (iteration = number of completed iterations). True: stop now.
  /// Does nothing unless due(iteration). `step` goes into the history. `moving`: the solver has a
  /// state beside s (multipliers) that still changes, so that an equal s is not a stall.
  bool stop(int iteration, const Eigen::Ref<const Vector>& s,
            double step = std::numeric_limits<double>::quiet_NaN(), bool moving = false);

  /// For solvers that find out by themselves that they are at their end, good or bad.
  void end(SolveStatus status, std::string message);

  /// Ends the solve where the caller asked for it (kInterrupted) or the time is over (kTimeLimit);
  /// true: stop now. For work that stop() does not see, such as an inner solver that came back.
  bool end_if_out_of_time(int iteration);

  /// Judges s now, whatever the cadence, without stopping: true when it meets the stop test.
  bool meets(const Eigen::Ref<const Vector>& s);

  /// Guarded error of the last judged iterate and of the best one.
  double last_error() const { return last_.guarded(); }
  double best_error() const { return best_error_; }
  const Vector& best_impulse() const { return best_s_; }
  const ContactErrorEvaluator& evaluator() const { return evaluator_; }

  double seconds() const;    ///< wall time since the start
  bool cancelled() const;    ///< the caller asked to stop
  bool out_of_time() const;  ///< cancelled or over the time limit, for loops within an iteration
  double remaining_seconds() const;
  /// Ends the set-up phase: seconds so far are reported as setup_seconds.
  void end_setup();

  /// Status, message, iterations, timings and the impulse: the last one if it converged, else the
  /// best.
  SolveResult finish();

 private:
  bool judge(const Eigen::Ref<const Vector>& s, double impulse_change);
  double replace_previous(int iteration, const Eigen::Ref<const Vector>& s);

  const ContactProblem& problem_;
  const SolverOptions& options_;
  ContactErrorEvaluator evaluator_;
  Stopwatch watch_;
  double setup_seconds_ = 0;
  ContactError last_;
  double best_error_ = std::numeric_limits<double>::infinity();
  Vector best_s_;
  Vector previous_;  // iterate of the judgement before (all iterations for the impulse test)
  int previous_iteration_ = -1;
  int next_ = 0;
  bool every_ = false;
  int portion_ = kJudgedPortion, roots_ = 1;
  int iterations_ = 0;
  double free_energy_;
  SolveStatus status_ = SolveStatus::kNotRun;
  std::string message_;
};

}  // namespace bipot
