#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/tradeoff/advice.h"
#include "bench/tradeoff/run_setting.h"
#include "bench/tradeoff/stretch.h"
#include "core/base/stopwatch.h"

namespace bipot {

/// The stages of an advice; each stores its results in it.
template <int D>
class Adviser {
 public:
  Adviser(const Scene<D>& scene, const Advice::Options& options);
  Advice advise();

 private:
  /// The wall time of an advice, and the fractions of it at which stages must be done.
  class TimeBudget {
   public:
    static constexpr double kTightRunEnd = 0.06, kRunEnd = 0.25, kStepsEnd = 0.5, kTrialsEnd = 0.75,
                            kLastTrialEnd = 0.8;

    /// Counts from construction; `limit` in seconds.
    explicit TimeBudget(double limit) : limit_(limit) {}
    /// Spent so far [s].
    double seconds() const { return watch_.seconds(); }
    /// Seconds until that part of the limit is spent; never below a millisecond.
    double until(double part) const { return std::max(1e-3, part * limit_ - seconds()); }
    bool past(double part) const { return seconds() >= part * limit_; }

   private:
    Stopwatch watch_;
    double limit_;
  };
  using Samples = std::vector<StretchSample>;
  using Starts = std::vector<const State<D>*>;

  void run_stages();
  /// Everything after the sampled run, on so many of its stretches and the hardest one.
  void look_at(int samples);
  void say(const std::string& stage) const {
    if (options_.say) options_.say(stage);
  }
  /// Bounds of a run that must be done at this part of the time.
  RunLimits until(double part, double accepted) const {
    return {.seconds_left = [this, part] { return time_.until(part); },
            .cancelled = options_.interrupted,
            .accepted = accepted};
  }
  RunSetting exact(double factor, double accuracy = 0) const {
    return {.solver = "auto", .tol = tight_, .step_factor = factor, .accuracy = accuracy};
  }
  /// Stretches from the states; empty if a step is not solved.
  Samples stretches(const Scene<D>& scene, const Starts& starts, const RunSetting& setting,
                    double part) const {
    Samples samples;
    for (const State<D>* start : starts) {
      samples.push_back(run_stretch(scene, *start, steps_, setting, until(part, 10 * setting.tol)));
      if (!samples.back().run.whole || options_.stopped()) return {};
    }
    return samples;
  }
  /// Runs the scene as tightly as time allows.
  void sample_run();
  void choose_stretches(int samples);
  /// Keeps states from which a stretch reaches over a step with contacts: states at every quarter
  /// of a stretch, of which that from the third last has the present in its middle. One of them is
  /// that of the deepest overlap.
  void run_to_sample(double tol, double part);
  /// Measures time steps, as many and on as many stretches as time allows.
  void study_time_step();
  static double seconds_of(const Samples& samples) {
    double seconds = 0;
    for (const StretchSample& sample : samples) seconds += sample.run.cpu;
    return seconds;
  }
  /// Cuts longer steps by accuracies, large to small, until one meets the goal. Overlaps stay below
  /// about three times the accuracy.
  void try_accuracies(const Starts& kept);
  const Samples& chosen_runs() const {
    return accuracy_ > 0 ? cut_runs_.at(accuracy_) : runs_.at(factor_);
  }
  /// Runs the stretches once more, as tightly, with the other kind of start: s = 0 instead of the
  /// previous step, or the reverse. Steps with several exact answers may then end at others.
  void measure_spread();
  RunSetting setting_of(const SolverVariant& variant, double tol) const {
    return {.solver = variant.solver,
            .tol = tol,
            .step_factor = factor_,
            .accuracy = accuracy_,
            .parameters = variant.parameters};
  }
  /// A solver at a tolerance against tight runs with the same step.
  Advice::SolverTrial try_solver(const SolverVariant& variant, double tol, const Samples& reference,
                                 double cpu_limit) const;
  /// Tries each solver from loose tolerances to tight until two meet the budget.
  void try_solvers();
  /// Tries solvers with the chosen step, and chooses one.
  void choose_solver();
  /// Stretches do not see the deepest overlap of another run: only the run itself does.
  void run_as_advised();

  const Scene<D>& scene_;
  const Advice::Options& options_;
  const TimeBudget time_;
  const int steps_;                                           // of a stretch, the scene's own
  double tight_ = 0, factor_ = 1, accuracy_ = 0, floor_ = 0;  // of sample_
  Advice advice_;
  std::vector<State<D>> starts_;
  std::optional<State<D>> hardest_;
  Starts sample_;
  std::size_t first_ = 0;               // of those for means
  std::map<double, Samples> runs_;      // tight ones of sample_, by the factor of their step
  std::map<double, Samples> cut_runs_;  // likewise, by accuracy
};

}  // namespace bipot
