// Steps with several exact answers: how many, and do statistics depend on the one that is taken?

#include <algorithm>
#include <cmath>

#include "bench/report/labels.h"
#include "bench/study/study.h"
#include "solvers/analysis/several_answers.h"
#include "solvers/simulation/step_solver.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

const std::string kAnswers = "answers", kEnsembles = "ensembles";
constexpr int kStarts = 6;         // of the search in one step
constexpr double kSearchTime = 2;  // wall seconds of it
constexpr double kExact = 1e-10;   // guarded error of the answers that runs take
constexpr double kRough = 1.2;     // friction at which several answers are common
constexpr double kExactTime = 1;   // CPU seconds to reach it by another family
const std::vector<std::string> kFamilies = {"ipm", "homotopy"};

/// Searches `looks` steps at equal distances, in the part of a run that averages are taken of.
Study::Values count_answers(const Study::Sample& sample, int looks, const Study::Stopped& stopped) {
  Scene<2> scene = sample.make();
  scene.solver = {.name = "auto", .tol = 1e-6};
  const int from = static_cast<int>(sample.averages_from(scene) / scene.step);
  const int every = std::max(1, (scene.num_steps - from) / looks);
  State<2> state = initial_state(scene);
  double searched = 0, several = 0, spread = 0;
  Study::Observer observer(sample, scene, 1);
  SceneRunOptions<2> options{.cancelled = stopped};
  options.on_step = [&](const SceneStep<2>& step) {
    observer.see(step.state);
    const int k = step.state.step;
    if (k < from || (k - from) % every != every / 2 || step.problem.num_contacts() == 0)
      return true;
    const SeveralAnswers found = find_several_answers(
        step.problem, {.starts = kStarts, .time_limit = kSearchTime, .cancelled = stopped});
    const auto exact = std::ranges::count_if(
        found.starts, [](const SeveralAnswers::Start& s) { return s.answer >= 0; });
    if (exact < 2) return true;  // one exact answer cannot be compared
    ++searched;
    if (found.answers.size() > 1) {
      ++several;
      spread = std::max(spread, found.spread.velocity);
    }
    return true;
  };
  const SceneRun<2> run = run_scene<2>(scene, state, options);
  if (run.end == SceneRun<2>::End::kFailed) throw *run.failure;
  Study::Values values = observer.values(state);
  return {{"searched", searched},
          {"several", several},
          {"spread", spread},
          {"inertial_number", values["inertial_number"]}};
}

/// What is varied about the shear of 100 disks with μ = 0.4 and three radii at I = 0.1, and the
/// friction of a pour that comes to rest.
std::vector<std::pair<std::string, Study::Sample>> answer_samples(bool quick) {
  std::vector<std::pair<std::string, Study::Sample>> all;
  const auto add = [&](const std::string& varied, Study::Sample sample) {
    if (sample.scene.empty()) sample.scene = "shear";
    all.emplace_back(sample.scene + ":" + varied, sample);
  };
  if (quick) {
    add("speed", {.size = 36, .drive = 1});
    add("mu", {.size = 36, .drive = 1, .mu = 0.8});
    return all;
  }
  for (const double drive : {0.1, 0.3, 1.0, 3.0, 10.0}) add("speed", {.drive = drive});
  for (const double mu : {0.1, 0.2, 0.6, 0.8, 1.0, 1.2, 2.0}) add("mu", {.mu = mu});
  for (const double mu : {0.2, 0.4, 0.8, 1.2}) add("mu", {.scene = "pour", .mu = mu});
  for (const double spread : {0.0, 2.0}) add("spread", {.spread = spread});
  for (const int size : {25, 50, 200, 400}) add("size", {.size = size});
  return all;
}

std::vector<Study::Job> answers_jobs(bool quick) {
  std::vector<Study::Job> jobs;
  for (int seed = 1; seed <= (quick ? 2 : 10); ++seed) {
    for (const auto& [varied, of_any_seed] : answer_samples(quick)) {
      Study::Sample sample = of_any_seed;
      sample.seed = seed;
      const double x = varied == "shear:speed"  ? sample.drive
                       : varied.ends_with("mu") ? sample.mu
                                                : sample.spread;
      jobs.push_back({{kAnswers, varied, sample.size, seed, "several", 0, x},
                      [=, looks = quick ? 3 : 8](const Study::Stopped& stopped) {
                        return count_answers(sample, looks, stopped);
                      }});
    }
  }
  return jobs;
}

/// Wilson's 95 % interval of a share.
std::pair<double, double> share_interval(double hits, double of) {
  constexpr double kZ = 1.96;
  const double p = hits / of, z2 = kZ * kZ;
  const double middle = (p + z2 / (2 * of)) / (1 + z2 / of);
  const double half = kZ / (1 + z2 / of) * std::sqrt(p * (1 - p) / of + z2 / (4 * of * of));
  return {std::max(middle - half, 0.0), std::min(middle + half, 1.0)};
}

Document answers_report(const Study::Measured& measured) {
  Document part;
  Table table{.columns = {{"varied", "varied"},
                          {"x", "value", &value_label},
                          {"size", "disks", &count_label},
                          {"inertial_number", "I", &compact_label},
                          {"searched", "steps searched", &count_label},
                          {"several", "with several answers", &count_label},
                          {"share", "share", &share_label},
                          {"low", "from", &share_label},
                          {"high", "to", &share_label},
                          {"spread", "largest difference of velocities", &compact_label}},
              .key = "answers"};
  const auto chart = [](Chart::Axis x, std::vector<Chart::Series> series, Chart::Key key) {
    return Chart{.title = "Steps with several exact answers",
                 .x = std::move(x),
                 .y = {.label = "share of the steps", .low = 0},
                 .series = std::move(series),
                 .key = key};
  };
  Chart::Series by_speed{"", 0, {}}, by_size{"", 0, {}};
  Chart::Series sheared{"shear", 0, {}}, poured{"pour, towards rest", 1, {}};
  for (const std::string& varied : distinct(measured, kAnswers, &Study::Case::scene)) {
    const auto here = [&](const Study::Case& c) { return c.scene == varied; };
    for (const int size : distinct<int>(measured, kAnswers, &Study::Case::size, here)) {
      for (const double x : distinct<double>(measured, kAnswers, &Study::Case::x, here)) {
        const Study::Case of{kAnswers, varied, size, 0, "several", 0, x};
        double searched = 0, several = 0, spread = 0;
        for (const auto& [seed, n] : by_seed(measured, of, "searched")) searched += n;
        for (const auto& [seed, n] : by_seed(measured, of, "several")) several += n;
        for (const auto& [seed, n] : by_seed(measured, of, "spread")) spread = std::max(spread, n);
        if (searched == 0) continue;
        const auto [low, high] = share_interval(several, searched);
        const double inertial = over_seeds(by_seed(measured, of, "inertial_number")).mean;
        table.add(
            {varied, x, size, inertial, searched, several, several / searched, low, high, spread});
        const Chart::Point point{.x = varied == "shear:speed"  ? inertial
                                      : varied.ends_with("mu") ? x
                                                               : size,
                                 .y = several / searched,
                                 .note = {},
                                 .y_low = low,
                                 .y_high = high};
        if (varied == "shear:speed") by_speed.points.push_back(point);
        if (varied == "shear:mu") sheared.points.push_back(point);
        if (varied == "pour:mu") poured.points.push_back(point);
        if (varied == "shear:speed" && x == 1) {
          sheared.points.push_back(point);
          sheared.points.back().x = Study::Sample().mu;
        }
        if (varied == "shear:size" || (varied == "shear:speed" && x == 1)) {
          by_size.points.push_back(point);
          by_size.points.back().x = size;
        }
      }
    }
  }
  for (Chart::Series* series : {&by_size, &sheared}) {
    std::ranges::sort(series->points, {}, &Chart::Point::x);
  }
  const auto log = Chart::Axis::Kind::kLog;
  part.add(Figure{.chart = chart({"friction coefficient"}, {sheared, poured}, Chart::Key::kBelow),
                  .file = "answers_friction.svg",
                  .caption =
                      "Share of steps with several exact answers against friction, 100 "
                      "disks, Wilson's 95 % interval; a lower bound, from six starts a step."});
  part.add(Figure{.chart = chart({"inertial number", log}, {by_speed}, Chart::Key::kNone),
                  .file = "answers_speed.svg",
                  .caption =
                      "Share of steps with several exact answers in plane shear of 100 disks, "
                      "Wilson's 95 % interval; a lower bound, from six starts a step."});
  part.add(Figure{.chart = chart({"number of disks", log}, {by_size}, Chart::Key::kNone),
                  .file = "answers_size.svg",
                  .caption = "The same against the number of disks, at I = 0.1."});
  part.add(std::move(table));
  return part;
}

/// Takes in each step the exact answer that `policy` names: that of a warm start by auto
/// ("nearest"), that of another family from zero, or the one farthest from the nearest.
class AnswerTaker {
 public:
  AnswerTaker(std::string policy, const Study::Stopped& stopped)
      : policy_(std::move(policy)), stopped_(stopped) {}

  StepSolution operator()(const ContactProblem& problem, const Vector& s0) {
    SolverOptions options{.tol = kExact, .s0 = s0, .cancelled = stopped_};
    SolveResult nearest = solve("auto", problem, options);
    ++steps_;
    if (problem.num_contacts() == 0 || policy_ == "nearest" || !is_success(nearest.status)) {
      return to_step_solution(std::move(nearest));
    }
    DistinctAnswers answers(problem);
    if (answers.add(nearest.s, "nearest") != 0) return to_step_solution(std::move(nearest));
    options.s0 = Vector();
    options.time_limit = kExactTime;
    double farthest = 0;
    SolveResult taken = nearest;
    for (const std::string& family : kFamilies) {
      if (policy_ != "farthest" && policy_ != family) continue;
      SolveResult other = solve(family, problem, options);
      if (!is_success(other.status) || answers.add(other.s, family) <= 0) continue;
      const double distance = answers.distance(other.s, nearest.s);
      if (distance <= farthest) continue;
      farthest = distance;
      taken = std::move(other);
    }
    changed_ += farthest > 0 ? 1 : 0;
    return to_step_solution(std::move(taken));
  }
  double changed() const { return changed_ / steps_; }

 private:
  std::string policy_;
  const Study::Stopped& stopped_;
  double steps_ = 0, changed_ = 0;
};

Study::Values take_answers(const Study::Sample& sample, const std::string& policy,
                           const Study::Stopped& stopped) {
  const Scene<2> scene = sample.make();
  Study::Observer observer(sample, scene, 1);
  AnswerTaker taker(policy, stopped);
  SceneRunOptions<2> options{.cancelled = stopped};
  options.solver = [&](const ContactProblem& p, const Vector& s0) { return taker(p, s0); };
  options.on_step = [&](const SceneStep<2>& step) {
    observer.see(step.state);
    return true;
  };
  State<2> state = initial_state(scene);
  const SceneRun<2> run = run_scene<2>(scene, state, options);
  if (run.end != SceneRun<2>::End::kCompleted) return {{"failed", 1}};
  Study::Values values = observer.values(state);
  values["unsolved"] = run.totals.steps - run.totals.converged;
  values["steps"] = run.totals.steps;
  values["changed"] = taker.changed();
  return values;
}

std::vector<Study::Job> ensembles_jobs(bool quick) {
  std::vector<Study::Job> jobs;
  for (int seed = 1; seed <= (quick ? 3 : 10); ++seed) {
    for (const char* scene : {"shear", "pour", "collapse"}) {
      for (const char* policy : {"nearest", "farthest", "ipm"}) {
        const Study::Sample sample{
            .scene = scene, .size = quick ? 25 : 64, .seed = seed, .mu = kRough};
        jobs.push_back(
            {{kEnsembles, scene, sample.size, seed, policy, kExact, kRough},
             [=](const Study::Stopped& stopped) { return take_answers(sample, policy, stopped); }});
      }
    }
  }
  return jobs;
}

Document ensembles_report(const Study::Measured& measured) {
  Document part;
  Table table{.columns = {{"scene", "scene"},
                          {"policy", "answers taken"},
                          {"quantity", "observable"},
                          {"nearest", "nearest answer", &value_label},
                          {"seeds_bar", "± of seeds", &compact_label},
                          {"difference", "difference", &compact_label},
                          {"bar", "± paired", &compact_label},
                          {"relative", "relative", &share_label},
                          {"z", "difference over bar", &ratio_label}},
              .key = "ensembles",
              .sortable = true};
  Table changed{.columns = {{"scene", "scene"},
                            {"policy", "answers taken"},
                            {"seeds", "seeds", &count_label},
                            {"changed", "steps with another answer", &share_label},
                            {"bar", "±", &share_label},
                            {"compared", "observables", &count_label},
                            {"beyond", "beyond their bar", &count_label},
                            {"expected", "expected by chance", &ratio_label},
                            {"largest", "largest over its bar", &ratio_label},
                            {"median_bar", "median bar, relative", &share_label}},
                .key = "policies"};
  for (const std::string& scene : distinct(measured, kEnsembles, &Study::Case::scene)) {
    const auto sizes = distinct(measured, kEnsembles, &Study::Case::size);
    for (const std::string& policy : distinct(measured, kEnsembles, &Study::Case::method)) {
      if (policy == "nearest") continue;
      const Study::Case base{kEnsembles, scene, sizes.back(), 0, "nearest", kExact, kRough};
      Study::Case of = base;
      of.method = policy;
      int compared = 0, beyond = 0;
      double largest = 0;
      std::vector<double> bars;
      for (const std::string& quantity : classed_quantities(measured, kEnsembles, scene)) {
        const auto nearest = by_seed(measured, base, quantity);
        const MeanValue mean = over_seeds(nearest);
        const MeanValue off = paired_difference(by_seed(measured, of, quantity), nearest);
        if (!(off.confidence > 0)) continue;
        const double ratio = std::abs(off.mean) / off.confidence;
        ++compared;
        beyond += ratio > 1 ? 1 : 0;
        largest = std::max(largest, ratio);
        bars.push_back(off.confidence / std::abs(mean.mean));
        table.add({scene, policy, quantity, mean.mean, mean.confidence, off.mean, off.confidence,
                   std::abs(off.mean / mean.mean), ratio});
      }
      const auto shares = by_seed(measured, of, "changed");
      const MeanValue share = over_seeds(shares);
      if (shares.empty()) continue;
      changed.add({scene, policy, static_cast<int>(shares.size()), share.mean, share.confidence,
                   compared, beyond, 0.05 * compared, largest, median(bars)});
    }
  }
  part.add(std::move(changed));
  part.fold("Every observable", std::move(table));
  return part;
}

}  // namespace

Study::Part answers_part() {
  return {kAnswers, "Several answers: how many steps have them?", &answers_jobs, &answers_report};
}

Study::Part ensembles_part() {
  return {kEnsembles, "Several answers: do statistics depend on the one that is taken?",
          &ensembles_jobs, &ensembles_report};
}

}  // namespace bipot
