#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "bench/tradeoff/adviser.h"

namespace bipot {

template <int D>
void Adviser<D>::study_time_step() {
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
    // Trials take the scene's time, to a hundredth.
    const double steps = scene_.num_steps / factor;
    if (std::abs(std::round(steps) - steps) > 0.01 * steps) continue;
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

template <int D>
void Adviser<D>::try_accuracies(const Starts& kept) {
  Advice::StepStudy& study = advice_.steps;
  const double overlap = advice_.goal.penetration;
  std::vector<double> ladder = {0.1, 0.03, 0.01};
  if (!std::isnan(overlap)) {
    std::erase_if(ladder, [&](double x) { return x > 0.5 * overlap; });
    if (advice_.cut > 0) ladder.push_back(advice_.cut);
    std::sort(ladder.rbegin(), ladder.rend());
  }
  if (scene_.has_cohesion()) ladder.clear();  // which excludes them
  const int factor = longest_cut_step(scene_, std::gcd(steps_ / 4, scene_.num_steps));
  const double equal = seconds_of(runs_.at(1));
  for (const double x : ladder) {
    const RunSetting setting = exact(factor, x);
    if (options_.stopped() || equal > time_.until(TimeBudget::kStepsEnd) ||
        !run_takes(scene_, setting)) {
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

template void Adviser<2>::study_time_step();
template void Adviser<3>::study_time_step();

}  // namespace bipot
