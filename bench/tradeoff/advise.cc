#include "bench/tradeoff/advise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "bench/tradeoff/advice_verdict.h"
#include "bench/tradeoff/adviser.h"
#include "core/base/number_text.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

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
  if (const double end = scene.num_steps * scene.step; options.window > 1.001 * end) {
    throw std::invalid_argument(fmt::format(
        "a window of {:g} s is longer than the {:g} s of the scene", options.window, end));
  }
  if (options.samples < 1) throw std::invalid_argument("at least one stretch must be sampled");
  for (const SolverVariant& variant : options.solvers) {
    require_solver(variant.solver);
    const auto same = [&](const SolverVariant& other) {
      return other.solver == variant.solver && other.parameters == variant.parameters;
    };
    if (std::ranges::count_if(options.solvers, same) > 1) {
      throw std::invalid_argument(fmt::format("solver '{}' is named twice", variant.solver));
    }
  }
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
    if (std::ranges::find(order, at) == order.end()) order.push_back(at);
  };
  if (wanted > 0) {
    for (std::size_t i : {wanted / 2, wanted - 1, std::size_t{0}}) add(even[i]);
  }
  for (std::size_t at : even) add(at);
  return order;
}

}  // namespace

template <int D>
Adviser<D>::Adviser(const Scene<D>& scene, const Advice::Options& options)
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
  if (const double overlap = advice_.goal.penetration; !std::isnan(overlap)) {
    // As it is printed and written.
    const double x = number_at(fmt::format("{:.2g}", std::clamp(overlap / 3, 1e-6, 0.3)));
    if (!scene.has_cohesion() && run_takes(scene, exact(1, x))) advice_.cut = x;
  }
  advice_.warm_start = scene.solver.warm_start;
  advice_.other_stop = scene.solver.stop != "guarded";
  advice_.cohesion_without_range = scene.has_cohesion() && scene.cohesion_range == 0;
}

template <int D>
Advice Adviser<D>::advise() {
  run_stages();
  advice_.seconds_spent = time_.seconds();
  if (options_.stopped()) {
    advice_.status = Advice::Status::kInterrupted;
    advice_.message = "stopped before an answer";
    advice_.choice = -1;
  }
  return advice_;
}

template <int D>
void Adviser<D>::run_stages() {
  sample_run();
  if (options_.stopped()) return;
  if (starts_.empty()) return conclude_without_contacts(options_, advice_);
  const Advice sampled = advice_;
  for (int samples = options_.samples;; samples *= Advice::kMoreSamples) {
    advice_ = sampled;
    look_at(samples);
    if (options_.stopped()) return;
    conclude(options_, advice_);
    // Bars that are too wide are narrowed, if the time allows.
    const bool wide =
        advice_.status == Advice::Status::kUndecided && advice_.choice >= 0 && !advice_.out_of_time;
    if (!wide || to_size(samples) >= starts_.size() ||
        (1 + Advice::kMoreSamples) * time_.seconds() > options_.time_limit) {
      return;
    }
  }
}

template <int D>
void Adviser<D>::look_at(int samples) {
  choose_stretches(samples);
  study_time_step();
  if (options_.stopped() || advice_.step.index < 0) return;
  choose_solver();
  if (!options_.stopped() && advice_.choice >= 0) run_as_advised();
}

template <int D>
void Adviser<D>::sample_run() {
  say("running the scene");
  run_to_sample(tight_, TimeBudget::kTightRunEnd);
  if (advice_.sample.steps_run < advice_.sample.steps_planned && !options_.stopped()) {
    run_to_sample(loose_tolerance(advice_.goal), TimeBudget::kRunEnd);
  }
}

template <int D>
void Adviser<D>::choose_stretches(int samples) {
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

template <int D>
void Adviser<D>::run_to_sample(double tol, double part) {
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
      if (starts_.size() > to_size(Advice::kMostSamples)) {
        for (std::size_t i = 1; 2 * i < starts_.size(); ++i) starts_[i] = std::move(starts_[2 * i]);
        starts_.resize((starts_.size() + 1) / 2);
        stride *= 2;
      }
    }
    return seen.steps_run == scene_.num_steps || !time_.past(part);
  };
  State<D> state = initial_state(scene_);
  const RunRecord run =
      run_setting(scene_, state, {.solver = "auto", .tol = tol}, until(part, kInfinity), observer);
  if (run.status == "failed") {
    seen.note = "the run ended: " + run.message;
    seen.failed = true;
  } else if (seen.steps_run < scene_.num_steps) {
    seen.note = fmt::format("time for the run was up after {} steps", seen.steps_run);
  }
  seen.unsolved = run.steps - run.steps_converged;
  seen.stretches = static_cast<int>(starts_.size());
  if (seen.steps_run > 0) {
    seen.overhead_seconds = std::max(0.0, run.cpu - run.solve_cpu) / seen.steps_run;
  }
}

template <int D>
void Adviser<D>::run_as_advised() {
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
