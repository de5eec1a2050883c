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

/// A sampled step, and the previous step for warm starts.
struct SampledProblem {
  TestProblem given;
  ContactProblem before;
  std::vector<Contact<2>> contacts;                ///< of `given`
  std::vector<ContactOutcome<2>> contacts_before;  ///< of `before`
  bool has_before = false;
  ReferenceSolution reference;
  Accuracy spread;  ///< of its exact answers; NaN if only one is known
  std::shared_ptr<TrueErrorEvaluator> true_error;
};

/// Impulses of the previous step at the contacts of the same pairs, in the problem's variables.
Vector carry_over(const SampledProblem& sample, const Vector& s_before);

struct Samples {
  std::vector<SampledProblem> chosen_on, fresh;
};
/// Problems with references, alternately to choose on and fresh ones, as many as time allows. Left
/// out are those without a reference clearly better than the goal, and those whose references
/// disagree without proof of several answers.
Samples sample_problems(const Scene<2>& scene, double factor,
                        const std::vector<const State<2>*>& sampled,
                        const std::vector<const State<2>*>& fresh, const AdviseOptions& options,
                        const TimeBudget& time, Advice& advice);

}  // namespace bipot
