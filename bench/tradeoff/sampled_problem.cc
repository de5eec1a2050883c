#include "bench/tradeoff/sampled_problem.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "bench/tradeoff/window_run.h"
#include "core/motion/warm_start.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

/// Takes steps of size h from the state (made with steps of h / factor) until impulses act. The
/// sample is the following step, if impulses act there as well; else that step, which then has no
/// predecessor. Empty if no impulse acts within twice the state's step and two steps more, or if a
/// step fails.
std::optional<SampledProblem> sample_problem(const Scene<2>& scene, State<2> state, double factor,
                                             const AdviseOptions& options, const TimeBudget& time) {
  SolverOptions solver;
  solver.tol = tight_tolerance(options.goal);
  solver.cancelled = options.interrupted;
  solver.time_limit = time.until(TimeBudget::kReferencesEnd);
  TimeStepper<2> stepper(scene, make_step_solver(require_solver("auto"), solver), false);
  scale_impulses(state, factor);
  SampledProblem sample;
  sample.given.step = scene.step;
  sample.given.smallest_radius = smallest_radius(scene);
  try {
    const int patience = static_cast<int>(std::ceil(2 / factor)) + 2;
    int active = 0;
    for (int k = 0; k < patience && active == 0; ++k) active = stepper.advance(state).active;
    if (active == 0) return std::nullopt;
    const std::vector<ContactOutcome<2>> first = state.contacts;
    sample.before = stepper.problem();
    if (stepper.advance(state).active == 0) {
      sample.given.problem = sample.before;
      return sample;
    }
    sample.given.problem = stepper.problem();
    sample.has_before = true;
    sample.contacts_before = first;
    for (const ContactOutcome<2>& out : state.contacts) sample.contacts.push_back(out.contact);
    return sample;
  } catch (const StepFailure&) {
    return std::nullopt;
  }
}

}  // namespace

Vector carry_over(const SampledProblem& sample, const Vector& s_before) {
  const ContactProblem& p = sample.before;
  const auto physical = [&](Eigen::Index row) {
    return s_before[row] / (p.row_scale.size() != 0 ? p.row_scale[row] : 1.0);
  };
  std::vector<ContactOutcome<2>> before = sample.contacts_before;
  for (std::size_t c = 0; c < before.size(); ++c) {
    const Eigen::Index row = static_cast<Eigen::Index>(c) * p.dim;
    before[c].s_n = physical(row);
    if (p.dim == 2) before[c].s_t = physical(row + 1);
  }
  return warm_start(before, sample.contacts, sample.given.problem);
}

Samples sample_problems(const Scene<2>& scene, double factor,
                        const std::vector<const State<2>*>& sampled,
                        const std::vector<const State<2>*>& fresh, const AdviseOptions& options,
                        const TimeBudget& time, Advice& advice) {
  constexpr double kReferenceSeconds = 5;
  constexpr double kAgree = 1e-5;  // relative difference of velocities
  // Tight enough for two references to prove that a step has several answers.
  const double target =
      std::clamp(1e-3 * smallest_goal(options.goal), 1e-12, ReferenceSolution::kTrusted);
  Samples samples;
  samples.chosen_on.reserve(sampled.size());  // evaluators point into them
  samples.fresh.reserve(fresh.size());
  const auto take = [&](const State<2>& state, std::vector<SampledProblem>& problems) {
    if (time.past(TimeBudget::kReferencesEnd) && !samples.chosen_on.empty()) return;
    if (options.stopped()) return;
    std::optional<SampledProblem> sample = sample_problem(scene, state, factor, options, time);
    if (!sample) return;
    problems.push_back(std::move(*sample));
    SampledProblem& made = problems.back();
    made.reference = find_reference(made.given, std::min(kReferenceSeconds, time.until(1)), target);
    const bool disagree = made.reference.velocity_spread > std::max(kAgree, 1e3 * target);
    if (made.reference.error.guarded() > 0.1 * smallest_goal(options.goal) ||
        (disagree && !made.reference.several())) {
      ++advice.without_reference;
      problems.pop_back();
      return;
    }
    advice.worst_reference = std::fmax(advice.worst_reference, made.reference.error.guarded());
    if (!made.reference.several()) {
      advice.reference_spread = std::fmax(advice.reference_spread, made.reference.velocity_spread);
    }
    made.true_error = std::make_shared<TrueErrorEvaluator>(made.given, made.reference);
    if (made.reference.several()) {
      ++advice.several_solutions;
      made.reference.spread = made.true_error->spread();
      const AnswerSpread& apart = made.reference.spread;
      made.spread = {.force = apart.force, .energy = apart.energy};
      advice.spread = worst_of(advice.spread, made.spread);
    }
  };
  // From the middle outwards: if time runs out, the middle is covered.
  const auto outwards = [](std::size_t k, std::size_t count) {
    const std::size_t middle = count / 2, away = (k + 1) / 2;
    return k % 2 == 0 ? middle + away : middle - away;
  };
  for (std::size_t k = 0; k < 2 * std::max(sampled.size(), fresh.size()) + 2; ++k) {
    if (const std::size_t i = outwards(k, sampled.size()); i < sampled.size()) {
      take(*sampled[i], samples.chosen_on);
    }
    if (const std::size_t i = outwards(k, fresh.size()); i < fresh.size()) {
      take(*fresh[i], samples.fresh);
    }
  }
  return samples;
}

}  // namespace bipot
