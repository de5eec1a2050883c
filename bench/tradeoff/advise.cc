#include "bench/tradeoff/advise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "bench/tradeoff/sampled_problem.h"
#include "bench/tradeoff/sampled_run.h"
#include "bench/tradeoff/solver_trials.h"
#include "bench/tradeoff/step_study.h"
#include "bench/tradeoff/stretch_trials.h"
#include "bench/tradeoff/time_budget.h"
#include "bench/tradeoff/window_run.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

void check_request(const Scene<2>& scene, const AdviseOptions& options) {
  bool asked = false;
  for (auto m : Accuracy::kMeasures) {
    const double x = options.goal.*m;
    if (std::isnan(x)) continue;
    asked = true;
    if (!(x > 0) || !std::isfinite(x)) {
      throw std::invalid_argument(
          fmt::format("{}: expected a positive number, got {}", name_of(m), x));
    }
  }
  if (!asked) throw std::invalid_argument("nothing is asked for: give at least one goal");
  if (scene.model != Model::kNonsmooth) {
    throw std::invalid_argument(
        "the scene asks for springs and dashpots (model dem), which solve no contact problem: "
        "there is no solver to advise");
  }
  if (scene.has_gates()) {
    throw std::invalid_argument(
        "bodies come or go by inlets and outlets: forces are compared body by body");
  }
  if (options.samples < 1 || options.fresh < 0) {
    throw std::invalid_argument("at least one step must be sampled");
  }
  for (const SolverVariant& variant : options.solvers) require_solver(variant.solver);
}

/// The cheapest of the trials that met the budget on stretches and also meet it on fresh steps.
void choose_trial(const std::vector<SampledProblem>& fresh, const AdviseOptions& options,
                  const TimeBudget& time, Advice& advice) {
  using Verdict = SolverTrial::Verdict;
  std::vector<SolverTrial> in_runs = advice.trials;  // their costs there
  const bool stretches = std::any_of(in_runs.begin(), in_runs.end(), [](const SolverTrial& t) {
    return t.verdict != Verdict::kNone;
  });
  for (SolverTrial& trial : in_runs) {
    if (trial.verdict == Verdict::kStretchMet) trial.seconds = trial.run_seconds;
  }
  for (int i : by_cost(in_runs, advice.budget)) {
    SolverTrial& trial = advice.trials[i];
    if (stretches && trial.verdict != Verdict::kStretchMet) continue;
    if (!fresh.empty()) {
      const TrialPair pair =
          try_solver(trial.solver, trial.tol, fresh,
                     std::max({time.until(1), 1.0, 20 * trial.seconds}), options);
      advice.fresh = trial.warm ? pair.warm : pair.cold;
      if (!meets(advice.fresh, advice.budget)) {
        trial.verdict = Verdict::kFreshMissed;
        continue;
      }
    }
    trial.verdict = Verdict::kChosen;
    advice.choice = i;
    return;
  }
  advice.choice = nearest_trial(advice.trials, advice.budget);
}

/// Checks the recommendation as a whole, from fresh states against the finest steps.
void check_windows(const Scene<2>& scene, const std::vector<const State<2>*>& states,
                   const AdviseOptions& options, const TimeBudget& time, Advice& advice) {
  if (advice.steps.finest == 0 || states.empty()) return;
  const SolverTrial& chosen = advice.trials[advice.choice];
  const WindowLength window = window_length(scene, options.window);
  SolverOptions tight, own;
  tight.tol = tight_tolerance(options.goal);
  own.tol = chosen.tol;
  own.parameters = chosen.solver.parameters;
  tight.cancelled = own.cancelled = options.interrupted;
  Scene<2> finest = scene, recommended = scene;
  finest.step = advice.steps.finest * scene.step;
  recommended.step = advice.step_size;
  recommended.solver.warm_start = chosen.warm;
  const auto left = [&time] { return time.until(1); };
  const StepSolver tried = limited_solver(require_solver(chosen.solver.solver), own, left);
  const StepSolver exact = limited_solver(require_solver("auto"), tight, left);
  std::vector<WindowRun> runs, references;
  double floor = 0;
  for (const State<2>* state : states) {
    if (time.past(1) || (options.stopped())) break;
    WindowRun run = run_window(recommended, *state, recommended.step / scene.step,
                               static_cast<int>(std::lround(window.seconds / recommended.step)),
                               tried, 10 * own.tol);
    WindowRun reference = run_window(finest, *state, advice.steps.finest,
                                     static_cast<int>(std::lround(window.seconds / finest.step)),
                                     exact, 10 * tight.tol);
    if (!run.usable || !reference.usable) continue;
    runs.push_back(std::move(run));
    references.push_back(std::move(reference));
    floor += energy_floor(scene, *state);
  }
  if (runs.empty()) return;
  advice.whole_windows = static_cast<int>(runs.size());
  advice.whole_window = window_errors(runs, references, smallest_radius(scene), floor);
}

/// "force error 1.2e-03 (goal 1e-03), energy error not measured (goal 1e-02)".
std::string held_against(const Accuracy& error, const Accuracy& goal) {
  std::string text;
  for (auto m : Accuracy::kMeasures) {
    if (std::isnan(goal.*m)) continue;
    text += fmt::format("{}{} {} (goal {:.0e})", text.empty() ? "" : ", ", name_of(m),
                        std::isnan(error.*m) ? "not measured" : fmt::format("{:.1e}", error.*m),
                        goal.*m);
  }
  return text;
}

/// Consequence of several exact answers of a step for the goal.
std::string several_sentence(const Advice& advice) {
  std::string apart;
  bool beyond = false;
  for (auto m : Accuracy::kMeasures) {
    if (std::isnan(advice.goal.*m) || std::isnan(advice.spread.*m)) continue;
    apart += fmt::format("{}{} {:.1e}", apart.empty() ? "" : ", ", name_of(m), advice.spread.*m);
    beyond = beyond || advice.spread.*m > advice.goal.*m;
  }
  std::string text = fmt::format(
      "{} of {} steps have several exact answers{}: no digits below half of that are paid for there",
      advice.several_solutions, advice.problems + advice.fresh_problems,
      apart.empty() ? "" : ", which differ by " + apart);
  if (beyond) text += ", and no solver can promise more for one body at one instant";
  return text;
}

/// A sentence if two exact runs of a stretch differ by more than the goal; else empty.
std::string beyond_stretches(const Advice& advice) {
  std::string apart;
  for (auto m : Accuracy::kMeasures) {
    if (!(advice.stretch_spread.*m > advice.goal.*m)) continue;
    apart +=
        fmt::format("{}{} {:.1e}", apart.empty() ? "" : ", ", name_of(m), advice.stretch_spread.*m);
  }
  if (apart.empty()) return {};
  return fmt::format(
      "two runs of the same stretches, both tighter than the goal, differ by {}: over a stretch "
      "digits below half of that are not paid for",
      apart);
}

/// Sets costs, status and message from the results.
void conclude(const Scene<2>& scene, Advice& advice) {
  if (advice.choice < 0) {
    advice.message = advice.trials.empty()
                         ? "no solver was tried: time was up; give more with --time-limit"
                         : "no solver reached its tolerance on all sampled steps";
    return;
  }
  const SolverTrial& chosen = advice.trials[advice.choice];
  const double share =
      static_cast<double>(advice.sample.contact_steps) / std::max(1, advice.sample.steps_run);
  advice.seconds_per_step = advice.sample.overhead_seconds +
                            share * (chosen.run_seconds > 0 ? chosen.run_seconds : chosen.seconds);
  advice.num_steps = static_cast<int>(std::lround(scene.num_steps * scene.step / advice.step_size));
  advice.seconds_in_all = advice.num_steps * advice.seconds_per_step;
  const bool solver_met = chosen.verdict == SolverTrial::Verdict::kChosen;
  const bool step_met = advice.step.index >= 0 && advice.step.met;
  if (advice.step.index < 0) {
    advice.message =
        "the error of the time step could not be measured: give more with --time-limit";
  } else if (!step_met) {
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
  } else if (!solver_met) {
    advice.message =
        fmt::format("no solver meets what the time step leaves; the best is {} to {:.0e} with {}",
                    chosen.solver.label, chosen.tol,
                    held_against(worst_of(chosen.error, chosen.stretch), advice.goal));
  } else if (advice.whole_windows > 0 &&
             share_of(without_lost_digits(advice.whole_window, advice.stretch_spread),
                      advice.goal) > 1) {
    advice.message =
        fmt::format("on fresh stretches of the run the recommendation misses the goal: {}",
                    held_against(advice.whole_window, advice.goal));
  } else {
    advice.status = Advice::Status::kMet;
    advice.message = "the goal is met on all sampled and fresh steps";
  }
  if (advice.several_solutions > 0) advice.message += "; " + several_sentence(advice);
  if (const std::string beyond = beyond_stretches(advice); !beyond.empty()) {
    advice.message += "; " + beyond;
  }
}

/// The stages of an advice; each stores its results in it.
class Adviser {
 public:
  Adviser(const Scene<2>& scene, const AdviseOptions& options)
      : scene_(scene), options_(options), time_(options.time_limit) {
    advice_.goal = options.goal;
    advice_.step_size = scene.step;
    advice_.num_steps = scene.num_steps;
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
  void run_stages() {
    sample_run();
    if (options_.stopped()) return;
    if (run_.checkpoints.empty()) return say_that_nothing_touched();
    study_time_step();
    if (options_.stopped()) return;
    try_and_choose();
    if (options_.stopped()) return;
    conclude(scene_, advice_);
  }

  void say(const char* stage) const {
    if (options_.say) options_.say(stage);
  }

  /// Runs the scene as tightly as time allows, and selects steps for trials.
  void sample_run() {
    say("running the scene");
    run_ = sampled_run(scene_, tight_tolerance(options_.goal), TimeBudget::kTightRunEnd, options_,
                       time_);
    if (run_.seen.steps_run < run_.seen.steps_planned && !options_.stopped()) {
      run_ =
          sampled_run(scene_, loose_tolerance(options_.goal), TimeBudget::kRunEnd, options_, time_);
    }
    advice_.sample = run_.seen;
    selection_ = select_steps(run_.checkpoints.size(), options_.samples, options_.fresh);
  }

  void say_that_nothing_touched() {
    const SceneSample& seen = run_.seen;
    const bool whole = seen.steps_run == seen.steps_planned;
    advice_.status = whole ? Advice::Status::kNoContacts : Advice::Status::kNotMet;
    advice_.message =
        whole ? "nothing touches in this scene: there is no contact problem to solve, any solver "
                "and tolerance will do"
              : fmt::format(
                    "nothing touches in the first {} of {} steps ({}): give more with --time-limit",
                    seen.steps_run, seen.steps_planned, seen.note);
  }

  std::vector<const State<2>*> states_of(const std::vector<std::size_t>& chosen) const {
    std::vector<const State<2>*> states;
    for (std::size_t i : chosen) states.push_back(&run_.checkpoints[i].state);
    return states;
  }

  static bool has_step(const std::vector<const State<2>*>& states, const State<2>* wanted) {
    return std::any_of(states.begin(), states.end(),
                       [&](const State<2>* state) { return state->step == wanted->step; });
  }

  void study_time_step() {
    say("measuring the time step");
    // Middle, last, first and between: if time runs out, the last ones are dropped.
    const std::size_t count = selection_.sample.size();
    for (std::size_t i : {count / 2, count - 1, std::size_t{0}, 3 * count / 4}) {
      const State<2>* lead = &run_.checkpoints[selection_.sample[i]].lead;
      if (!has_step(starts_, lead)) starts_.push_back(lead);
    }
    study_ = study_steps(scene_, starts_, options_, time_);
    advice_.steps = study_.study;
    if (options_.stopped()) return;
    advice_.step = choose_step(advice_.steps.steps, options_.goal);
    if (advice_.step.index >= 0) {
      advice_.step_size = advice_.steps.steps[advice_.step.index].step;
      advice_.step_error = advice_.steps.steps[advice_.step.index].error;
    }
    advice_.budget = solver_budget(options_.goal, advice_.step_error);
  }

  void try_and_choose() {
    say("solving for references");
    Scene<2> stepped = scene_;
    stepped.step = advice_.step_size;
    const double factor =
        advice_.step.index < 0 ? 1 : advice_.steps.steps[advice_.step.index].factor;
    const Samples samples = sample_problems(stepped, factor, states_of(selection_.sample),
                                            states_of(selection_.fresh), options_, time_, advice_);
    advice_.problems = static_cast<int>(samples.chosen_on.size());
    advice_.fresh_problems = static_cast<int>(samples.fresh.size());
    if (options_.stopped() || samples.chosen_on.empty()) return;
    try_solvers(samples.chosen_on, options_, time_, advice_);
    if (options_.stopped()) return;
    if (study_.runs.contains(factor)) {
      say("trying stretches of the run");
      StretchReference reference{
          stepped,      factor,        advice_.steps.window,  tight_tolerance(options_.goal),
          study_.floor, study_.starts, study_.runs.at(factor)};
      measure_spread(reference, options_, time_);
      advice_.stretch_spread = reference.spread;
      try_stretches(std::move(reference), samples.chosen_on, options_, time_, advice_);
    }
    mark_pareto(advice_.trials, options_.goal);
    say("verifying on fresh steps");
    choose_trial(samples.fresh, options_, time_, advice_);
    if (options_.stopped() || advice_.choice < 0) return;
    if (advice_.trials[advice_.choice].verdict == SolverTrial::Verdict::kChosen) {
      check_windows(scene_, unseen_leads(), options_, time_, advice_);
    }
  }

  /// Starts of windows that were not used in the study of the time step.
  std::vector<const State<2>*> unseen_leads() const {
    std::vector<const State<2>*> leads;
    for (std::size_t i : selection_.fresh) {
      const State<2>* lead = &run_.checkpoints[i].lead;
      if (!has_step(starts_, lead) && !has_step(leads, lead)) leads.push_back(lead);
    }
    return leads;
  }

  const Scene<2>& scene_;
  const AdviseOptions& options_;
  const TimeBudget time_;
  Advice advice_;
  SampledRun run_;
  Selection selection_;
  std::vector<const State<2>*> starts_;  // of the windows used in the study of the time step
  StepRuns study_;
};

}  // namespace

Advice advise(const Scene<2>& scene, const AdviseOptions& options) {
  check_request(scene, options);
  return Adviser(scene, options).advise();
}

}  // namespace bipot
