#include "bench/tradeoff/advise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "bench/measure/limited_solve.h"
#include "bench/report/labels.h"
#include "bench/tradeoff/stretch.h"
#include "bench/tradeoff/time_budget.h"
#include "core/base/number_text.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

constexpr int kMaxStarts = 64;
constexpr int kMoreSamples = 4;  // times as many halve the bars

template <int D>
void check_request(const Scene<D>& scene, const Advice::Options& options) {
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    const double x = options.goal.*m;
    if (!std::isnan(x) && (!(x > 0) || !std::isfinite(x))) {
      throw std::invalid_argument(fmt::format("{}: expected a positive number, got {}", name, x));
    }
  }
  if (scene.model != Model::kNonsmooth) {
    throw std::invalid_argument(
        "the scene asks for springs and dashpots (model dem), which solve no contact problem: "
        "there is no solver to advise");
  }
  if (options.samples < 1) throw std::invalid_argument("at least one stretch must be sampled");
  for (const SolverVariant& variant : options.solvers) require_solver(variant.solver);
}

/// Indices of evenly spaced stretches: middle, last, first and the rest, of which the last ones are
/// dropped if time runs out.
std::vector<std::size_t> select(std::size_t available, int samples) {
  const std::size_t wanted = std::min(available, to_size(samples));
  std::vector<std::size_t> even, order;
  for (std::size_t i = 0; i < wanted; ++i) {
    even.push_back(wanted == 1 ? 0 : i * (available - 1) / (wanted - 1));
  }
  const auto add = [&](std::size_t at) {
    if (std::find(order.begin(), order.end(), at) == order.end()) order.push_back(at);
  };
  if (wanted > 0) {
    for (std::size_t i : {wanted / 2, wanted - 1, std::size_t{0}}) add(even[i]);
  }
  for (std::size_t at : even) add(at);
  return order;
}

/// The errors beyond their goals: "energy 1.2e-1 of 5e-2"; without one, that nearest to its goal.
std::string held_against(const MeasuredError& measured, const Accuracy& goal) {
  Accuracy beyond;
  const Accuracy bound = measured.bound();
  const double worst = share_of(bound, goal);
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (bound.*m / goal.*m >= std::min(worst, 1.0)) beyond.*m = goal.*m;
  }
  return error_against(measured, beyond);
}

/// A sentence if two exact runs of a stretch differ by more than the goal; else empty.
std::string beyond_goal(const Advice& advice) {
  std::string apart;
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (!(advice.spread.*m > advice.goal.*m)) continue;
    apart +=
        fmt::format("{}{} {}", apart.empty() ? "" : ", ", name, compact_label(advice.spread.*m));
  }
  if (apart.empty()) return {};
  return fmt::format(
      "; two exact runs of the same stretches differ by up to {}: digits below that are not paid for",
      apart);
}

/// Sets costs, status and message from the results.
void conclude(const Advice::Options& options, Advice& advice) {
  const std::string more = fmt::format("give --time-limit {:g}", 4 * options.time_limit);
  if (advice.choice < 0) {
    advice.status = Advice::Status::kUndecided;
    advice.message = !advice.trials.empty() && !advice.out_of_time
                         ? "no solver reached its tolerance on all stretches"
                         : "time was up before a solver was tried on all stretches: " + more;
    if (!advice.out_of_time && !advice.trials.empty()) advice.status = Advice::Status::kNotMet;
    return;
  }
  const Advice::SolverTrial& chosen = advice.trials[to_size(advice.choice)];
  const Advice::Run& run = advice.run;
  const double share =
      static_cast<double>(advice.sample.contact_steps) / std::max(1, advice.sample.steps_run);
  advice.seconds_per_step =
      run.steps > 0 ? run.cpu / run.steps : advice.sample.overhead_seconds + share * chosen.seconds;
  advice.seconds_in_all = advice.num_steps * advice.seconds_per_step;
  const MeasuredError expected = expected_error(advice);
  const bool settled = share_of(expected.least(), advice.goal) > 1;
  advice.status = settled ? Advice::Status::kNotMet : Advice::Status::kUndecided;
  if (run.unsolved > 0) {
    advice.status = Advice::Status::kNotMet;
    advice.message = fmt::format("{} of {} steps of the run as advised were not solved",
                                 run.unsolved, run.steps);
  } else if (!run.failure.empty()) {
    advice.status = Advice::Status::kNotMet;
    advice.message = "the run as advised ends: " + run.failure;
  } else if (run.overlap > advice.goal.penetration) {
    const double shorter = 0.9 * advice.goal.penetration / run.overlap;
    advice.message =
        fmt::format("the run as advised has an overlap of {} in step {}; try {} {:.1g}",
                    share_label(run.overlap), run.overlap_step,
                    advice.accuracy > 0 ? "--accuracy" : "--step-size",
                    shorter * (advice.accuracy > 0 ? advice.accuracy : advice.step_size));
  } else if (advice.step.index < 0) {
    advice.message = "the error of the time step could not be measured in time: " + more;
  } else if (!advice.step.met) {
    const Advice::StepTrial& large = advice.steps.steps.front();
    double small = large.step;
    std::string accuracies;
    for (const Advice::StepTrial& t : advice.steps.steps) {
      if (t.accuracy == 0) small = t.step;
      if (t.accuracy > 0) accuracies += fmt::format(" nor accuracy {:.2g}", t.accuracy);
    }
    const std::string tried =
        (large.step == small ? fmt::format("no time step tried ({:g} s alone)", large.step)
                             : fmt::format("no time step from {:g} to {:g} s", large.step, small)) +
        accuracies;
    const char* what =
        settled ? "meets the goal" : "surely leaves a tenth of the goal to the solver";
    advice.message =
        fmt::format("{} {}; of {}: {}", tried, what,
                    advice.accuracy > 0 ? fmt::format("accuracy {:.2g}", advice.accuracy)
                                        : fmt::format("{:g} s", advice.step_size),
                    held_against(advice.step_error, advice.goal));
  } else if (chosen.verdict != Advice::SolverTrial::Verdict::kChosen) {
    advice.message = fmt::format(
        "{}; the best is {} to {} with {}",
        advice.out_of_time ? "time was up before all solvers were tried: " + more
                           : "no solver surely meets what the time step leaves",
        chosen.solver.label, tolerance_label(chosen.tol), held_against(chosen.error, advice.goal));
  } else if (!run.whole() && advice.sample.steps_run < advice.sample.steps_planned) {
    advice.message = fmt::format(
        "the goal is met on the first {:.3g} of {:.3g} s; the rest was not looked at: {}",
        std::max(advice.sample.steps_run * advice.scene_step, run.steps * advice.step_size),
        advice.duration, more);
  } else {
    advice.status = Advice::Status::kMet;
    advice.message = "the goal is met on all stretches";
    if (run.whole() && !std::isnan(advice.goal.penetration)) {
      advice.message += ", and overlaps stay below it in the whole run";
    }
  }
  if (advice.status == Advice::Status::kUndecided &&
      advice.message.find(more) == std::string::npos) {
    advice.message += fmt::format(": give --samples {} --time-limit {:g}",
                                  std::min(kMoreSamples * advice.steps.windows, int{kMaxStarts}),
                                  4 * options.time_limit);
  }
  advice.message += beyond_goal(advice);
}

/// The stages of an advice; each stores its results in it.
template <int D>
class Adviser {
 public:
  Adviser(const Scene<D>& scene, const Advice::Options& options)
      : scene_(scene),
        options_(options),
        time_(options.time_limit),
        steps_(stretch_steps(scene, options.window)) {
    advice_.goal = options.goal;
    advice_.default_goal = !std::isfinite(smallest_goal(options.goal));
    if (advice_.default_goal) advice_.goal = default_goal(scene);
    tight_ = tight_tolerance(advice_.goal);
    advice_.scene = scene.source;
    advice_.title = scene.title;
    advice_.scene_step = advice_.step_size = scene.step;
    advice_.num_steps = scene.num_steps;
    advice_.duration = scene.num_steps * scene.step;
    advice_.warm_start = scene.solver.warm_start;
    advice_.cohesion_without_range = scene.has_cohesion() && scene.cohesion_range == 0;
  }

  Advice advise() {
    run_stages();
    advice_.seconds_spent = time_.seconds();
    if (options_.stopped()) {
      advice_.status = Advice::Status::kInterrupted;
      advice_.message = "stopped before an answer";
      advice_.choice = -1;
    }
    return advice_;
  }

 private:
  using Samples = std::vector<StretchSample>;
  using Starts = std::vector<const State<D>*>;

  void run_stages() {
    sample_run();
    if (options_.stopped()) return;
    if (starts_.empty()) return say_that_nothing_touched();
    const Advice sampled = advice_;
    for (int samples = options_.samples;; samples *= kMoreSamples) {
      advice_ = sampled;
      look_at(samples);
      if (options_.stopped()) return;
      conclude(options_, advice_);
      // Bars that are too wide are narrowed, if the time allows.
      const bool wide = advice_.status == Advice::Status::kUndecided && advice_.choice >= 0 &&
                        !advice_.out_of_time;
      if (!wide || to_size(samples) >= starts_.size() ||
          (1 + kMoreSamples) * time_.seconds() > options_.time_limit) {
        return;
      }
    }
  }

  /// Everything after the sampled run, on so many of its stretches and the hardest one.
  void look_at(int samples) {
    choose_stretches(samples);
    study_time_step();
    if (options_.stopped() || advice_.step.index < 0) return;
    measure_spread();
    try_solvers();
    mark_pareto(advice_.trials, advice_.goal);
    choose();
    if (!options_.stopped() && advice_.choice >= 0) run_as_advised();
  }

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
  void sample_run() {
    say("running the scene");
    run_to_sample(tight_, TimeBudget::kTightRunEnd);
    if (advice_.sample.steps_run < advice_.sample.steps_planned && !options_.stopped()) {
      run_to_sample(loose_tolerance(advice_.goal), TimeBudget::kRunEnd);
    }
  }

  void choose_stretches(int samples) {
    sample_.clear();
    runs_.clear();
    cut_runs_.clear();
    factor_ = 1;
    accuracy_ = 0;
    floor_ = 0;
    if (hardest_) sample_.push_back(&*hardest_);
    for (std::size_t i : select(starts_.size(), samples)) {
      if (!hardest_ || starts_[i].step != hardest_->step) sample_.push_back(&starts_[i]);
    }
  }

  /// Keeps states from which a stretch reaches over a step with contacts: states at every quarter
  /// of a stretch, of which that from the third last has the present in its middle. One of them is
  /// that of the deepest overlap.
  void run_to_sample(double tol, double part) {
    Advice::Sample& seen = advice_.sample;
    seen = {.steps_planned = scene_.num_steps};
    starts_.clear();
    hardest_.reset();
    const int quarter = steps_ / 4;
    std::deque<State<D>> leads;
    int stride = 1, last = -1, candidates = 0;
    RunObserver<D> observer;
    observer.before_step = [&](State<D>& next) {
      if (seen.steps_run % quarter != 0) return;
      leads.push_back(next);
      if (leads.size() > 3) leads.pop_front();
    };
    observer.on_step = [&](const SceneStep<D>& step) {
      ++seen.steps_run;
      seen.contacts_max = std::max(seen.contacts_max, step.report.contacts);
      if (step.report.overlap > seen.overlap) {
        seen.overlap = step.report.overlap;
        if (!hardest_ || hardest_->step != leads.front().step) hardest_ = leads.front();
      }
      if (step.report.contacts > 0) {
        ++seen.contact_steps;
        if (leads.front().step != last) {
          last = leads.front().step;
          if (candidates++ % stride == 0) starts_.push_back(leads.front());
        }
        if (starts_.size() > to_size(kMaxStarts)) {
          for (std::size_t i = 1; 2 * i < starts_.size(); ++i) {
            starts_[i] = std::move(starts_[2 * i]);
          }
          starts_.resize((starts_.size() + 1) / 2);
          stride *= 2;
        }
      }
      return seen.steps_run == scene_.num_steps || !time_.past(part);
    };
    State<D> state = initial_state(scene_);
    const RunRecord run = run_setting(scene_, state, {.solver = "auto", .tol = tol},
                                      until(part, kInfinity), observer);
    if (run.status == "failed") {
      seen.note = "the run ended: " + run.message;
    } else if (seen.steps_run < scene_.num_steps) {
      seen.note = fmt::format("time for the run was up after {} steps", seen.steps_run);
    }
    if (seen.steps_run > 0) {
      seen.overhead_seconds = std::max(0.0, run.cpu - run.solve_cpu) / seen.steps_run;
    }
  }

  void say_that_nothing_touched() {
    const Advice::Sample& seen = advice_.sample;
    const bool whole = seen.steps_run == seen.steps_planned;
    advice_.status = whole ? Advice::Status::kNoContacts : Advice::Status::kUndecided;
    advice_.message =
        whole ? "nothing touches in this scene: there is no contact problem to solve, any solver "
                "and tolerance will do"
              : fmt::format(
                    "nothing touches in the first {} of {} steps ({}): give "
                    "--time-limit {:g}",
                    seen.steps_run, seen.steps_planned, seen.note, 4 * options_.time_limit);
  }

  /// Measures time steps, as many and on as many stretches as time allows.
  void study_time_step() {
    say("measuring the time step");
    Advice::StepStudy& study = advice_.steps;
    study.window = steps_ * scene_.step;
    // The scene's own step and half of it: the minimum for a stretch. The first one is
    // indispensable and may take longer.
    double halves = 0, slowest = 0;  // seconds
    Starts kept;
    for (const State<D>* start : sample_) {
      if (options_.stopped()) return;
      if (!kept.empty() && slowest > time_.until(TimeBudget::kStepsEnd)) break;
      const double part = kept.empty() ? TimeBudget::kTrialsEnd : TimeBudget::kStepsEnd;
      const double begin = time_.seconds();
      Samples whole = stretches(scene_, {start}, exact(1), part);
      const double between = time_.seconds();
      Samples half = whole.empty() ? whole : stretches(scene_, {start}, exact(0.5), part);
      slowest = std::max(slowest, time_.seconds() - begin);
      if (half.empty()) continue;
      halves += time_.seconds() - between;
      kept.push_back(start);
      runs_[1].push_back(std::move(whole.front()));
      runs_[0.5].push_back(std::move(half.front()));
    }
    study.windows = static_cast<int>(kept.size());
    study.windows_dropped = static_cast<int>(sample_.size() - kept.size());
    sample_ = kept;
    if (kept.empty()) return;
    // Chosen for its overlap, the hardest one says nothing about means over time.
    first_ = hardest_ && kept.size() > 1 && kept.front() == &*hardest_ ? 1 : 0;
    for (std::size_t k = first_; k < kept.size(); ++k) floor_ += energy_floor(scene_, *kept[k]);
    // Then further levels as time allows; a level counts if all stretches are complete.
    const double overlap = advice_.sample.overlap;
    for (double factor : {2.0, 4.0, 0.25, 0.125, 0.0625}) {
      if (options_.stopped()) return;
      if (options_.keep_step && factor > 1) continue;
      // Steps that the overlap forbids, and finer ones than it asks for.
      if (factor > 1 && factor * overlap > advice_.goal.penetration) continue;
      if (factor < 0.1 && !(0.25 * overlap > advice_.goal.penetration)) continue;
      if (halves * 0.5 / factor > time_.until(TimeBudget::kStepsEnd)) continue;
      Samples level = stretches(scene_, kept, exact(factor), TimeBudget::kStepsEnd);
      if (!level.empty()) runs_[factor] = std::move(level);
    }
    study.finest = runs_.begin()->first;
    for (auto level = runs_.rbegin(); level != runs_.rend(); ++level) {
      const double factor = level->first;
      if (factor == study.finest || (options_.keep_step && factor != 1)) continue;
      Advice::StepTrial trial{factor, factor * scene_.step,
                              stretch_errors(level->second, runs_.begin()->second, floor_, first_)};
      double& deepest = trial.error.error.penetration;
      deepest = std::fmax(deepest, factor * overlap);
      for (const auto& [m, key, name] : Accuracy::kMeasures) {
        if (m == &Accuracy::penetration) continue;
        trial.error.error.*m *= factor / (factor - study.finest);
        trial.error.bar.*m *= factor / (factor - study.finest);
      }
      trial.seconds = seconds_of(level->second);
      study.steps.push_back(trial);
    }
    if (!options_.keep_step) try_accuracies(kept);
    advice_.step = choose_step(study.steps, advice_.goal);
    if (advice_.step.index >= 0) {
      const Advice::StepTrial& chosen = study.steps[to_size(advice_.step.index)];
      factor_ = chosen.factor;
      advice_.accuracy = accuracy_ = chosen.accuracy;
      advice_.step_size = chosen.step;
      advice_.step_error = chosen.error;
    }
    advice_.num_steps = static_cast<int>(std::lround(advice_.duration / advice_.step_size));
    advice_.budget = solver_budget(advice_.goal, advice_.step_error.bound());
  }

  static double seconds_of(const Samples& samples) {
    double seconds = 0;
    for (const StretchSample& sample : samples) seconds += sample.run.cpu;
    return seconds;
  }

  /// Cuts longer steps by accuracies, large to small, until one meets the goal. Overlaps stay below
  /// about three times the accuracy.
  void try_accuracies(const Starts& kept) {
    Advice::StepStudy& study = advice_.steps;
    const double overlap = advice_.goal.penetration;
    std::vector<double> ladder = {0.1, 0.03, 0.01};
    if (!std::isnan(overlap)) {
      std::erase_if(ladder, [&](double x) { return x > 0.5 * overlap; });
      // As it is printed and written.
      ladder.push_back(number_at(fmt::format("{:.2g}", std::clamp(overlap / 3, 1e-6, 0.3))));
      std::sort(ladder.rbegin(), ladder.rend());
    }
    if (scene_.has_cohesion()) ladder.clear();  // which excludes them
    const int factor = longest_cut_step(scene_, std::gcd(steps_ / 4, scene_.num_steps));
    const double equal = seconds_of(runs_.at(1));
    for (const double x : ladder) {
      const RunSetting setting = exact(factor, x);
      if (options_.stopped() || equal > time_.until(TimeBudget::kStepsEnd) ||
          !validate(with_setting(scene_, setting)).empty()) {
        return;
      }
      Samples level = stretches(scene_, kept, setting, TimeBudget::kStepsEnd);
      if (level.empty()) return;
      study.steps.push_back({.factor = setting.step_factor,
                             .step = setting.step_factor * scene_.step,
                             .error = stretch_errors(level, runs_.begin()->second, floor_, first_),
                             .accuracy = x,
                             .seconds = seconds_of(level)});
      const bool met = share_of(study.steps.back().error.bound(), advice_.goal) <= 1;
      cut_runs_[x] = std::move(level);
      if (met) return;
    }
  }

  const Samples& chosen_runs() const {
    return accuracy_ > 0 ? cut_runs_.at(accuracy_) : runs_.at(factor_);
  }

  /// Runs the stretches once more, as tightly, with the other kind of start: s = 0 instead of the
  /// previous step, or the reverse. Steps with several exact answers may then end at others.
  void measure_spread() {
    Scene<D> other = scene_;
    other.solver.warm_start = !other.solver.warm_start;
    const Samples samples =
        stretches(other, sample_, exact(factor_, accuracy_), TimeBudget::kTrialsEnd);
    if (!samples.empty()) {
      advice_.spread = added_errors(samples, chosen_runs(), floor_, first_).bound();
    }
  }

  RunSetting setting_of(const SolverVariant& variant, double tol) const {
    return {.solver = variant.solver,
            .tol = tol,
            .step_factor = factor_,
            .accuracy = accuracy_,
            .parameters = variant.parameters};
  }

  /// A solver at a tolerance against tight runs with the same step.
  Advice::SolverTrial try_solver(const SolverVariant& variant, double tol, const Samples& reference,
                                 double cpu_limit) const {
    Advice::SolverTrial trial{
        .solver = variant, .tol = tol, .stretches = static_cast<int>(sample_.size())};
    const RunSetting setting = setting_of(variant, tol);
    Samples samples;
    double cpu = 0;
    int solves = 0, steps = 0;
    for (const State<D>* start : sample_) {
      RunLimits limits = until(TimeBudget::kLastTrialEnd, tol);
      limits.cpu_seconds = cpu_limit - cpu;
      samples.push_back(run_stretch(scene_, *start, steps_, setting, limits));
      const RunRecord& run = samples.back().run;
      cpu += run.cpu;
      solves += run.solves;
      steps += run.steps;
      trial.seconds += run.solve_cpu;
      trial.iterations += run.iterations * run.steps;
      trial.guarded = std::fmax(trial.guarded, run.worst_guarded);
      if (!run.whole) {
        trial.message = fmt::format("{}: {}", run.status, run.message);
        if (cpu > cpu_limit) trial.message = fmt::format("more than {:.2g} s of CPU", cpu_limit);
        break;
      }
      ++trial.solved;
    }
    trial.seconds /= std::max(1, solves);
    trial.iterations /= std::max(1, steps);
    if (trial.solved == trial.stretches) {
      trial.error = added_errors(samples, reference, floor_, first_);
    }
    return trial;
  }

  /// Tries each solver from loose tolerances to tight until two meet the budget.
  void try_solvers() {
    std::vector<SolverVariant> variants = options_.solvers;
    if (variants.empty()) variants = promising_solvers(advice_.sample.contacts_max);
    for (const SolverVariant& variant : variants) warm_up(require_solver(variant.solver));
    Samples reference = chosen_runs();
    double reference_tol = tight_, best = kInfinity;  // CPU seconds of all stretches
    int solves = 0;
    for (const StretchSample& sample : reference) solves += sample.run.solves;
    for (const SolverVariant& variant : variants) {
      say("trying " + variant.label);
      int met = 0;
      for (int k = 1; k <= 12 && met < 2; ++k) {
        if (options_.stopped()) return;
        if (time_.past(TimeBudget::kTrialsEnd)) {
          advice_.out_of_time = true;
          return;
        }
        const double tol = std::pow(10.0, -k);
        // A trial no looser than the reference cannot be judged by it.
        constexpr double kTighter = 0.1;
        if (reference_tol > 1.01 * kTighter * tol) {
          RunSetting tighter = exact(factor_, accuracy_);
          tighter.tol = kTighter * tol;
          Samples more = stretches(scene_, sample_, tighter, TimeBudget::kLastTrialEnd);
          if (more.empty()) break;
          reference = std::move(more);
          reference_tol = tighter.tol;
        }
        // A solver that takes four times as long as the best so far is left.
        Advice::SolverTrial trial = try_solver(variant, tol, reference, std::max(0.25, 4 * best));
        const bool solved = trial.solved == trial.stretches;
        if (meets(trial, advice_.budget, advice_.spread)) {
          ++met;
          trial.verdict = Advice::SolverTrial::Verdict::kMet;
          best = std::min(best, trial.seconds * solves);
        }
        advice_.trials.push_back(std::move(trial));
        if (!solved) break;
      }
    }
  }

  /// The cheapest of those that meet the budget, else the nearest.
  void choose() {
    const std::vector<int> order = by_cost(advice_.trials, advice_.budget, advice_.spread);
    advice_.choice = order.empty() ? nearest_trial(advice_.trials, advice_.budget) : order.front();
    if (order.empty()) return;
    advice_.trials[to_size(order.front())].verdict = Advice::SolverTrial::Verdict::kChosen;
  }

  /// Stretches do not see the deepest overlap of another run: only the run itself does.
  void run_as_advised() {
    say("running the scene as advised");
    const Advice::SolverTrial& chosen = advice_.trials[to_size(advice_.choice)];
    State<D> state = initial_state(scene_);
    const RunRecord run =
        run_setting(scene_, state, setting_of(chosen.solver, chosen.tol), until(1, kInfinity),
                    {.on_step = [this](const auto&) { return !time_.past(1); }});
    advice_.run = {.steps = run.steps,
                   .steps_planned = run.steps_planned,
                   .unsolved = run.steps - run.steps_converged,
                   .cpu = run.cpu,
                   .overlap = std::fmax(run.penetration, 0),
                   .overlap_step = run.penetration_step};
    if (run.status == "failed") advice_.run.failure = run.message;
  }

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

}  // namespace

template <int D>
Accuracy default_goal(const Scene<D>& scene) {
  constexpr double kGoal = 5e-2;
  Accuracy goal{.penetration = kDeepOverlap, .energy = kGoal};
  if (!scene.walls.empty()) goal.load = kGoal;
  if (scene.cell.in_x || scene.cell.in_y) goal.stress_ratio = kGoal;
  return goal;
}

template Accuracy default_goal(const Scene<2>&);
template Accuracy default_goal(const Scene<3>&);

Advice advise(const AnyScene& scene, const Advice::Options& options) {
  return std::visit(
      [&]<int D>(const Scene<D>& in) {
        check_request(in, options);
        return Adviser<D>(in, options).advise();
      },
      scene);
}

}  // namespace bipot
