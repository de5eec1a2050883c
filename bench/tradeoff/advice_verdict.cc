#include "bench/tradeoff/advice_verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/report/labels.h"
#include "bench/report/text_lines.h"

namespace bipot {
namespace {

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
      "; two exact runs of the same stretches differ by up to {}: smaller errors mean nothing",
      apart);
}

/// What would narrow the bars.
std::string what_helps(const Advice::Options& options, const Advice& advice) {
  const std::string time = fmt::format("--time-limit {:g}", 4 * options.time_limit);
  const int used = advice.steps.windows;
  if (advice.steps.windows_dropped > 0) return "give " + time;
  if (used < advice.sample.stretches) {
    return fmt::format("give --samples {} {}",
                       std::min(Advice::kMoreSamples * used, int{Advice::kMostSamples}), time);
  }
  return fmt::format("the scene has no more stretches: let it run for more than {:g} s{}",
                     advice.duration, options.window > 0 ? ", or give a shorter --window" : "");
}

}  // namespace

void conclude(const Advice::Options& options, Advice& advice) {
  const std::string more = fmt::format("give --time-limit {:g}", 4 * options.time_limit);
  if (advice.choice < 0 && advice.sample.mostly_unsolved()) {
    advice.status = Advice::Status::kNotMet;
    advice.message = fmt::format(
        "{} of {} steps of the run were not solved: `bipot run` says why, mend the scene first",
        advice.sample.unsolved, advice.sample.steps_run);
    return;
  }
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
    advice.message = "the run as advised ends: " + short_reason(run.failure);
  } else if (run.overlap > advice.goal.penetration) {
    const double shorter = 0.9 * advice.goal.penetration / run.overlap;
    advice.message =
        fmt::format("the run as advised has an overlap of {} in step {}; try {} {:.1g}",
                    overlap_label(run.overlap), run.overlap_step,
                    advice.accuracy > 0 ? "--accuracy" : "--step-size",
                    shorter * (advice.accuracy > 0 ? advice.accuracy : advice.step_size));
  } else if (advice.step.index < 0) {
    advice.message = "the error of the time step could not be measured in time: " + more;
  } else if (!settled && !bars_known(advice.step_error, advice.goal)) {
    advice.message = "means over a single stretch have no error bars";
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
        settled ? "meets the goal" : "has an error that is surely below nine tenths of the goal";
    advice.message =
        fmt::format("{} {}; at {}: {}", tried, what,
                    advice.accuracy > 0 ? fmt::format("accuracy {:.2g}", advice.accuracy)
                                        : fmt::format("{:g} s", advice.step_size),
                    held_against(advice.step_error, advice.goal));
  } else if (chosen.verdict != Advice::SolverTrial::Verdict::kChosen) {
    advice.message = fmt::format(
        "{}; the best is {} to {} with {}",
        advice.out_of_time ? "time was up before all solvers were tried: " + more
                           : "no solver is surely as exact as the time step allows",
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
    advice.message += ": " + what_helps(options, advice);
  }
  advice.message += beyond_goal(advice);
}

void conclude_without_contacts(const Advice::Options& options, Advice& advice) {
  const Advice::Sample& seen = advice.sample;
  const bool whole = seen.steps_run == seen.steps_planned;
  advice.status = whole ? Advice::Status::kNoContacts : Advice::Status::kUndecided;
  if (whole) {
    advice.message =
        "nothing touches in this scene: there is no contact problem to solve, any solver and "
        "tolerance will do";
    return;
  }
  advice.message =
      fmt::format("nothing touches in the first {} of {} steps ({}): {}", seen.steps_run,
                  seen.steps_planned, short_reason(seen.note),
                  seen.failed ? "mend the scene first, see bipot run"
                              : fmt::format("give --time-limit {:g}", 4 * options.time_limit));
}

}  // namespace bipot
