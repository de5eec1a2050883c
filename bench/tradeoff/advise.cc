#include "bench/tradeoff/advise.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <stdexcept>
#include <utility>

#include "bench/measure/warm_up.h"
#include "bench/report/labels.h"
#include "bench/tradeoff/stretch.h"
#include "bench/tradeoff/time_budget.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

constexpr std::size_t kMaxStarts = 64;

template <int D>
void check_request(const Scene<D>& scene, const AdviseOptions& options) {
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
  if (options.samples < 1 || options.fresh < 0) {
    throw std::invalid_argument("at least one stretch must be sampled");
  }
  for (const SolverVariant& variant : options.solvers) require_solver(variant.solver);
}

/// Indices of stretches to choose on and to verify on: evenly spaced, every third one fresh.
struct Selection {
  std::vector<std::size_t> sample, fresh;
};
Selection select(std::size_t available, int samples, int fresh) {
  Selection selection;
  const std::size_t wanted = std::min<std::size_t>(available, to_size(samples + fresh));
  for (std::size_t i = 0; i < wanted; ++i) {
    const std::size_t at = wanted == 1 ? 0 : i * (available - 1) / (wanted - 1);
    // The second of each group is fresh; the first and the last one stay in the sample.
    const int all = samples + fresh, next = static_cast<int>(i) + 2;
    const bool take = i + 1 < wanted && next * fresh / all > (next - 1) * fresh / all;
    (take ? selection.fresh : selection.sample).push_back(at);
  }
  // Middle, last, first and the rest: if time runs out, the last ones are dropped.
  const std::vector<std::size_t> sample = selection.sample;
  selection.sample.clear();
  const auto add = [&](std::size_t at) {
    if (std::find(selection.sample.begin(), selection.sample.end(), at) == selection.sample.end()) {
      selection.sample.push_back(at);
    }
  };
  for (std::size_t i : {sample.size() / 2, sample.size() - 1, std::size_t{0}}) {
    if (!sample.empty()) add(sample[i]);
  }
  for (std::size_t at : sample) add(at);
  return selection;
}

/// The errors beyond their goals: "energy 1.2e-1 of 5e-2"; without one, that nearest to its goal.
std::string held_against(const Accuracy& error, const Accuracy& goal) {
  std::string text;
  const double worst = share_of(error, goal);
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (!(error.*m / goal.*m >= std::min(worst, 1.0))) continue;
    text += fmt::format("{}{} {} of {}", text.empty() ? "" : ", ", name, compact_label(error.*m),
                        compact_label(goal.*m));
  }
  return text;
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
      "; two exact runs of the same stretches differ by {}: digits below half of that are not paid "
      "for",
      apart);
}

/// Sets costs, status and message from the results.
void conclude(const AdviseOptions& options, Advice& advice) {
  const std::string more = fmt::format("give --time-limit {:g}", 4 * options.time_limit);
  if (advice.choice < 0) {
    advice.status = Advice::Status::kUndecided;
    advice.message = !advice.trials.empty() && !advice.out_of_time
                         ? "no solver reached its tolerance on all stretches"
                         : "time was up before a solver was tried on all stretches: " + more;
    if (!advice.out_of_time && !advice.trials.empty()) advice.status = Advice::Status::kNotMet;
    return;
  }
  const SolverTrial& chosen = advice.trials[to_size(advice.choice)];
  const double share =
      static_cast<double>(advice.sample.contact_steps) / std::max(1, advice.sample.steps_run);
  advice.seconds_per_step = advice.sample.overhead_seconds + share * chosen.seconds;
  advice.num_steps = static_cast<int>(std::lround(advice.duration / advice.step_size));
  advice.seconds_in_all = advice.num_steps * advice.seconds_per_step;
  const std::string best =
      fmt::format("the best is {} to {} with {}", chosen.solver.label, tolerance_label(chosen.tol),
                  held_against(chosen.error, advice.goal));
  if (advice.step.index < 0) {
    advice.status = Advice::Status::kUndecided;
    advice.message = "the error of the time step could not be measured in time: " + more;
  } else if (!advice.step.met) {
    const StepTrial &large = advice.steps.steps.front(), &small = advice.steps.steps.back();
    const char* what = share_of(advice.step_error, advice.goal) > 1
                           ? "meets the goal"
                           : "leaves a tenth of the goal to the solver";
    advice.message =
        advice.steps.steps.size() == 1
            ? fmt::format("of the time steps tried ({:g} s alone) none {}: {}", large.step, what,
                          held_against(advice.step_error, advice.goal))
            : fmt::format("no time step from {:g} to {:g} s {}; the best is {:g} s with {}",
                          large.step, small.step, what, advice.step_size,
                          held_against(advice.step_error, advice.goal));
  } else if (chosen.verdict != SolverTrial::Verdict::kChosen) {
    if (advice.out_of_time) advice.status = Advice::Status::kUndecided;
    advice.message =
        advice.out_of_time
            ? fmt::format("time was up before all solvers were tried: {}; so far {}", more, best)
            : "no solver meets what the time step leaves; " + best;
  } else if (share_of(without_lost_digits(advice.whole, advice.spread), advice.goal) > 1) {
    advice.message = fmt::format("on fresh stretches it misses the goal: {}",
                                 held_against(advice.whole, advice.goal));
  } else {
    advice.status = Advice::Status::kMet;
    advice.message = advice.fresh.stretches > 0
                         ? "the goal is met on all stretches, those not chosen on included"
                         : "the goal is met on the stretches that it was chosen on";
  }
  advice.message += beyond_goal(advice);
}

/// The stages of an advice; each stores its results in it.
template <int D>
class Adviser {
 public:
  Adviser(const Scene<D>& scene, const AdviseOptions& options)
      : scene_(scene),
        options_(options),
        time_(options.time_limit),
        steps_(stretch_steps(scene, options.window)),
        radius_(smallest_radius(scene)) {
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
  }

  Advice advise() {
    run_stages();
    advice_.seconds_spent = time_.seconds();
    if (options_.stopped()) {
      advice_.status = Advice::Status::kInterrupted;
      advice_.message = "interrupted";
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
    study_time_step();
    if (options_.stopped()) return;
    if (advice_.step.index >= 0) {
      measure_spread();
      try_solvers();
      mark_pareto(advice_.trials, advice_.goal);
      if (!options_.stopped()) choose();
    }
    if (!options_.stopped()) conclude(options_, advice_);
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
  RunSetting exact(double factor) const {
    return {.solver = "auto", .tol = tight_, .step_factor = factor};
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

  /// Runs the scene as tightly as time allows, and selects starts of stretches.
  void sample_run() {
    say("running the scene");
    run_to_sample(tight_, TimeBudget::kTightRunEnd);
    if (advice_.sample.steps_run < advice_.sample.steps_planned && !options_.stopped()) {
      run_to_sample(loose_tolerance(advice_.goal), TimeBudget::kRunEnd);
    }
    const Selection selection = select(starts_.size(), options_.samples, options_.fresh);
    for (std::size_t i : selection.sample) sample_.push_back(&starts_[i]);
    for (std::size_t i : selection.fresh) fresh_.push_back(&starts_[i]);
  }

  /// Keeps states from which a stretch reaches over a step with contacts: states at every quarter
  /// of a stretch, of which that from the third last has the present in its middle.
  void run_to_sample(double tol, double part) {
    SceneSample& seen = advice_.sample;
    seen = {.steps_planned = scene_.num_steps};
    starts_.clear();
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
      if (step.report.contacts > 0) {
        ++seen.contact_steps;
        if (leads.front().step != last) {
          last = leads.front().step;
          if (candidates++ % stride == 0) starts_.push_back(leads.front());
        }
        if (starts_.size() > kMaxStarts) {
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
    const SceneSample& seen = advice_.sample;
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
    StepStudy& study = advice_.steps;
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
      floor_ += energy_floor(scene_, *start);
    }
    study.windows = static_cast<int>(kept.size());
    study.windows_dropped = static_cast<int>(sample_.size() - kept.size());
    sample_ = kept;
    if (kept.empty()) return;
    // Then further levels as time allows; a level counts if all stretches are complete.
    for (double factor : {2.0, 4.0, 0.25, 0.125}) {
      if (options_.stopped()) return;
      if (options_.keep_step && factor > 1) continue;
      if (halves * 0.5 / factor > time_.until(TimeBudget::kStepsEnd)) continue;
      Samples level = stretches(scene_, kept, exact(factor), TimeBudget::kStepsEnd);
      if (!level.empty()) runs_[factor] = std::move(level);
    }
    study.finest = runs_.begin()->first;
    for (auto level = runs_.rbegin(); level != runs_.rend(); ++level) {
      const double factor = level->first;
      if (factor == study.finest || (options_.keep_step && factor != 1)) continue;
      StepTrial trial{factor, factor * scene_.step,
                      stretch_errors(level->second, runs_.begin()->second, radius_, floor_)};
      for (const auto& [m, key, name] : Accuracy::kMeasures) {
        if (m != &Accuracy::penetration) trial.error.*m *= factor / (factor - study.finest);
      }
      study.steps.push_back(trial);
    }
    advice_.step = choose_step(study.steps, advice_.goal);
    if (advice_.step.index >= 0) {
      const StepTrial& chosen = study.steps[to_size(advice_.step.index)];
      factor_ = chosen.factor;
      advice_.step_size = chosen.step;
      advice_.step_error = chosen.error;
    }
    advice_.budget = solver_budget(advice_.goal, advice_.step_error);
  }

  /// Runs the stretches once more, as tightly, with the other kind of start: s = 0 instead of the
  /// previous step, or the reverse. Steps with several exact answers may then end at others.
  void measure_spread() {
    Scene<D> other = scene_;
    other.solver.warm_start = !other.solver.warm_start;
    const Samples samples = stretches(other, sample_, exact(factor_), TimeBudget::kTrialsEnd);
    if (!samples.empty()) {
      advice_.spread = added_errors(samples, runs_.at(factor_), radius_, floor_);
    }
  }

  /// A solver at a tolerance against tight runs with the same step. `samples`: its own.
  SolverTrial try_solver(const SolverVariant& variant, double tol, const Starts& starts,
                         const Samples& reference, double floor, double cpu_limit,
                         Samples& samples) const {
    SolverTrial trial{.solver = variant, .tol = tol, .stretches = static_cast<int>(starts.size())};
    const RunSetting setting{.solver = variant.solver,
                             .tol = tol,
                             .step_factor = factor_,
                             .parameters = variant.parameters};
    samples.clear();
    double cpu = 0;
    int solves = 0, steps = 0;
    for (const State<D>* start : starts) {
      RunLimits limits = until(1, tol);
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
        break;
      }
      ++trial.solved;
    }
    trial.seconds /= std::max(1, solves);
    trial.iterations /= std::max(1, steps);
    if (trial.solved == trial.stretches) {
      trial.error = added_errors(samples, reference, radius_, floor);
    }
    return trial;
  }

  /// Tries each solver from loose tolerances to tight until two meet the budget: a reserve for the
  /// fresh stretches.
  void try_solvers() {
    std::vector<SolverVariant> variants = options_.solvers;
    if (variants.empty()) variants = promising_solvers(advice_.sample.contacts_max);
    for (const SolverVariant& variant : variants) warm_up(require_solver(variant.solver));
    Samples reference = runs_.at(factor_), own;
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
          RunSetting tighter = exact(factor_);
          tighter.tol = kTighter * tol;
          Samples more = stretches(scene_, sample_, tighter, 1);
          if (more.empty()) break;
          reference = std::move(more);
          reference_tol = tighter.tol;
        }
        // A solver that takes four times as long as the best so far is left.
        SolverTrial trial =
            try_solver(variant, tol, sample_, reference, floor_, std::max(0.25, 4 * best), own);
        const bool solved = trial.solved == trial.stretches;
        if (meets(trial, advice_.budget, advice_.spread)) {
          ++met;
          trial.verdict = SolverTrial::Verdict::kMet;
          best = std::min(best, trial.seconds * solves);
        }
        advice_.trials.push_back(std::move(trial));
        if (!solved) break;
      }
    }
  }

  /// The cheapest of those that also meet the budget on fresh stretches. There it is compared, as a
  /// whole, with the finest steps.
  void choose() {
    using Verdict = SolverTrial::Verdict;
    say("verifying on fresh stretches");
    const Samples same = stretches(scene_, fresh_, exact(factor_), 1);
    Samples own;
    double floor = 0;
    for (const State<D>* start : fresh_) floor += energy_floor(scene_, *start);
    for (int i : by_cost(advice_.trials, advice_.budget, advice_.spread)) {
      SolverTrial& trial = advice_.trials[to_size(i)];
      if (!same.empty()) {
        advice_.fresh = try_solver(trial.solver, trial.tol, fresh_, same, floor, kInfinity, own);
        if (!meets(advice_.fresh, advice_.budget, advice_.spread)) {
          if (!time_.past(1)) {
            trial.verdict = Verdict::kFreshMissed;
            continue;
          }
          advice_.fresh = {};
        }
      }
      trial.verdict = Verdict::kChosen;
      advice_.choice = i;
      break;
    }
    if (advice_.choice < 0) advice_.choice = nearest_trial(advice_.trials, advice_.budget);
    const bool verified = advice_.choice >= 0 && advice_.fresh.stretches > 0 &&
                          advice_.trials[to_size(advice_.choice)].verdict == Verdict::kChosen;
    if (!verified) return;
    const Samples fine = stretches(scene_, fresh_, exact(advice_.steps.finest), 1);
    if (!fine.empty()) advice_.whole = stretch_errors(own, fine, radius_, floor);
  }

  const Scene<D>& scene_;
  const AdviseOptions& options_;
  const TimeBudget time_;
  const int steps_;  // of a stretch, the scene's own
  const double radius_;
  double tight_ = 0, factor_ = 1, floor_ = 0;  // of sample_
  Advice advice_;
  std::vector<State<D>> starts_;
  Starts sample_, fresh_;
  std::map<double, Samples> runs_;  // tight ones of sample_, by the factor of their step
};

}  // namespace

template <int D>
Accuracy default_goal(const Scene<D>& scene) {
  constexpr double kGoal = 5e-2;
  Accuracy goal{.energy = kGoal};
  if (!scene.walls.empty()) goal.load = kGoal;
  if (scene.cell.in_x || scene.cell.in_y) goal.stress_ratio = kGoal;
  return goal;
}

template Accuracy default_goal(const Scene<2>&);
template Accuracy default_goal(const Scene<3>&);

Advice advise(const AnyScene& scene, const AdviseOptions& options) {
  return std::visit(
      [&]<int D>(const Scene<D>& in) {
        check_request(in, options);
        return Adviser<D>(in, options).advise();
      },
      scene);
}

}  // namespace bipot
