#pragma once

#include <memory>
#include <vector>

#include "bench/measure/reference_solution.h"
#include "bench/measure/test_problem.h"
#include "bench/measure/true_error.h"
#include "bench/tradeoff/advice.h"
#include "bench/tradeoff/time_budget.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// A sampled step, and the step before it for warm starts.
struct SampledProblem {
  TestProblem given;
  ContactProblem before;
  std::vector<Contact<2>> contacts;                ///< of `given`
  std::vector<ContactOutcome<2>> contacts_before;  ///< of `before`
  bool has_before = false;
  ReferenceSolution reference;
  Accuracy spread;  ///< of its exact answers; NaN where a single one is known
  std::shared_ptr<TrueErrorEvaluator> true_error;
};

/// Impulses of the step before at the contacts of the same pairs, in the problem's variables.
Vector carry_over(const SampledProblem& sample, const Vector& s_before);

struct Samples {
  std::vector<SampledProblem> chosen_on, fresh;
};
/// Problems with references, to choose on and fresh ones in turn, as many as time allows. Those
/// without a reference that is clearly better than the goal, or where two disagree without proof of
/// several answers, are left out.
Samples sample_problems(const Scene<2>& scene, double factor,
                        const std::vector<const State<2>*>& sampled,
                        const std::vector<const State<2>*>& fresh, const AdviseOptions& options,
                        const TimeBudget& time, Advice& advice);

}  // namespace bipot
