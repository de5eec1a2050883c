#include "bench/tradeoff/step_study.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace bipot {

StepRuns study_steps(const Scene<2>& scene, const std::vector<const State<2>*>& starts,
                     const AdviseOptions& options, const TimeBudget& time) {
  StepRuns all;
  StepStudy& study = all.study;
  const WindowLength window = window_length(scene, options.window);
  study.window = window.seconds;
  SolverOptions tight;
  tight.tol = tight_tolerance(options.goal);
  tight.cancelled = options.interrupted;
  double end = TimeBudget::kTrialsEnd;  // the first window may take longer: it is indispensable
  const StepSolver solver =
      limited_solver(require_solver("auto"), tight, [&] { return time.until(end); });
  const auto run = [&](const State<2>* start, double factor) {
    Scene<2> other = scene;
    other.step = factor * scene.step;
    return run_window(other, *start, factor, static_cast<int>(std::lround(window.steps / factor)),
                      solver, 10 * tight.tol);
  };

  // The scene's own step and half of it: the minimum for a window.
  double halves = 0;  // seconds for the half steps of all windows kept
  double slowest = 0;
  for (const State<2>* start : starts) {
    if (options.stopped()) return all;
    if (!all.starts.empty() && slowest > time.until(TimeBudget::kStepsEnd)) break;
    const double begin = time.seconds();
    WindowRun whole = run(start, 1);
    const double between = time.seconds();
    WindowRun half = whole.usable ? run(start, 0.5) : WindowRun();
    slowest = std::max(slowest, time.seconds() - begin);
    if (!half.usable) continue;
    halves += time.seconds() - between;
    all.starts.push_back(start);
    all.runs[1].push_back(std::move(whole));
    all.runs[0.5].push_back(std::move(half));
    all.floor += energy_floor(scene, *start);
    end = TimeBudget::kStepsEnd;
  }
  study.windows = static_cast<int>(all.starts.size());
  study.windows_dropped = static_cast<int>(starts.size() - all.starts.size());
  if (all.starts.empty()) return all;

  // Then further levels as time allows; a level counts if all windows are complete.
  for (double factor : {2.0, 4.0, 0.25, 0.125}) {
    if (options.keep_step && factor > 1) continue;
    if (halves * 0.5 / factor > time.until(TimeBudget::kStepsEnd)) continue;
    std::vector<WindowRun> level;
    for (const State<2>* start : all.starts) {
      if (options.stopped()) return all;
      level.push_back(run(start, factor));
      if (!level.back().usable) break;
    }
    if (level.back().usable) all.runs[factor] = std::move(level);
  }
  study.finest = all.runs.begin()->first;
  const std::vector<WindowRun>& reference = all.runs.at(study.finest);
  for (auto level = all.runs.rbegin(); level != all.runs.rend(); ++level) {
    const double factor = level->first;
    if (factor == study.finest || (options.keep_step && factor != 1)) continue;
    StepTrial trial{factor, factor * scene.step,
                    window_errors(level->second, reference, smallest_radius(scene), all.floor)};
    const double scale = factor / (factor - study.finest);
    trial.error.force *= scale;
    trial.error.energy *= scale;
    study.steps.push_back(trial);
  }
  return all;
}

}  // namespace bipot
