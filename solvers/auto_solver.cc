#include "solvers/auto_solver.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <exception>

#include "core/contact_error.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

// Below this many contacts a factorisation costs less than the sweeps that it saves.
constexpr int kSmall = 400;
// Above it, proximal Newton (a factorisation of 2 d contacts unknowns a step) is tried last.
constexpr int kLarge = 4000;
// Above it, apgd is known to reach what the interior point does not (settled piles, mu = 0.3).
constexpr int kHuge = 10000;
constexpr int kUnlimited = std::numeric_limits<int>::max();

bool is_hyperstatic(const ContactProblem& p) {
  // Without H the rank is not known: dense packings are the rule.
  return !p.has_velocities() || p.num_rows() > p.num_dofs();
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

std::vector<AutoStage> plan_auto(const ContactProblem& p, const SolverOptions& options) {
  const int contacts = p.num_contacts();
  const bool warm = options.s0.size() != 0 && options.s0.squaredNorm() > 0;
  const bool loose = options.tol >= 1e-3;
  std::vector<AutoStage> stages;
  const auto add = [&](const char* solver, int cap, std::string reason,
                       std::map<std::string, std::string> parameters = {}) {
    if (find_solver(solver) == nullptr) return;
    stages.push_back({solver, cap, std::move(parameters), std::move(reason)});
  };

  const bool local = !p.has_velocities();
  if (contacts <= kSmall || (local && contacts <= kLarge)) {
    if (local) {
      add("pgs", warm ? 500 : 200, "few contacts: sweeps are the quickest where they converge");
      if (loose) add("apgd", 5000, "loose tolerance: momentum before factorisations");
    } else {
      add("apgd", loose ? 5000 : 1500, "bodies given: momentum is cheap and mostly enough");
    }
    add("newton", 6000, "factorisations are cheap at this size, and Newton is accurate");
    add("ipm", 600, "Newton needs a good start; the interior point does not");
    add("newton", 3000, "again, from the best impulse so far, with more sweeps before",
        {{"start_sweeps", "5000"}});
    add("apgd", 200000, "what second order could not do: long runs of first order");
    add("pgs", kUnlimited, "last resort: sweeps, which approach where nothing converges");
    return stages;
  }
  // An interior point iteration costs a few hundred of apgd's: the caps give both about equal time.
  const int first = contacts > kHuge || loose ? 40000 : 6000;
  add("apgd", first, "many contacts: momentum gives O(sqrt N) iterations on regular packings");
  if (!is_hyperstatic(p) && contacts <= kLarge) {
    add("newton", 100, "not hyperstatic: W is regular as a rule, and Newton quadratic");
  }
  add("ipm", 150, "accuracy on piles: a handful of factorisations, whatever the start",
      {{"arclength", "off"}, {"rounds", "1"}});
  add("apgd", 100000, "where the interior point stalls, long runs of first order may not");
  if (contacts <= kLarge) add("newton", 1000, "proximal Newton from the best impulse");
  add("ipm", 2000, "arclength continuation through folds, restarts");
  add("pgs", kUnlimited, "last resort: sweeps, which approach where nothing converges");
  return stages;
}

std::string explain_auto(const ContactProblem& p, const SolverOptions& options) {
  std::string text = fmt::format(
      "auto: {} contacts, d = {}, {}, {} start, tolerance {:.0e}\n", p.num_contacts(), p.dim,
      !p.has_velocities() ? "local form"
      : is_hyperstatic(p) ? "hyperstatic (more rows than degrees of freedom)"
                          : "not hyperstatic by count",
      options.s0.size() != 0 ? "warm" : "cold", options.tol);
  int number = 0;
  for (const AutoStage& stage : plan_auto(p, options)) {
    text += fmt::format("  {}. {:<7}{}  {}\n", ++number, stage.solver,
                        stage.max_iterations == kUnlimited
                            ? std::string(" (no cap)")
                            : fmt::format(" (cap {})", stage.max_iterations),
                        stage.reason);
  }
  return text;
}

SolveResult solve_auto(const ContactProblem& p, const SolverOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  ContactErrorEvaluator evaluate(p);
  SolveResult best;
  best.s = options.s0.size() != 0 ? options.s0 : Vector(Vector::Zero(p.num_rows()));
  double best_error = evaluate(best.s).guarded();
  if (std::isnan(best_error)) best_error = std::numeric_limits<double>::infinity();
  const double start_error = best_error;
  double setup_seconds = 0;
  int iterations = 0;
  std::string trail;
  SolverOptions inner = options;
  SolveStatus last = SolveStatus::kIterationLimit;

  const std::vector<AutoStage> stages = plan_auto(p, options);
  for (const AutoStage& stage : stages) {
    const double left = options.time_limit - seconds_since(start);
    if (left <= 0) {
      last = SolveStatus::kTimeLimit;
      break;
    }
    if (iterations >= options.max_iterations) {
      last = SolveStatus::kIterationLimit;
      break;
    }
    inner.s0 = best.s;
    inner.time_limit = left;
    inner.max_iterations = std::min(stage.max_iterations, options.max_iterations - iterations);
    inner.parameters = stage.parameters;
    if (options.on_iteration) {
      const double stage_start = seconds_since(start);
      inner.on_iteration = [&options, iterations, stage_start](const IterationRecord& r) {
        if (iterations > 0 && r.iteration == 0) return;  // the impulse that the last stage left
        IterationRecord shifted = r;
        shifted.iteration += iterations;
        shifted.seconds += stage_start;
        options.on_iteration(shifted);
      };
    }
    SolveResult result;
    try {
      result = find_solver(stage.solver)->run(p, inner);
    } catch (const std::exception& e) {
      result.status = SolveStatus::kNumericalFailure;
      result.message = e.what();
    }
    iterations += result.iterations;
    setup_seconds += result.setup_seconds;
    last = result.status;
    double error = std::numeric_limits<double>::infinity();
    ContactError measured;
    if (result.s.size() == p.num_rows() && result.s.allFinite()) {
      measured = evaluate(result.s);
      error = measured.guarded();
    }
    trail += fmt::format("{}{} {}: {} ({:.1e})", trail.empty() ? "" : "; ", stage.solver,
                         result.iterations, to_string(result.status), error);
    if (error < best_error || is_success(result.status)) {
      best_error = error;
      best.s = result.s;
    }
    if (last == SolveStatus::kInterrupted || last == SolveStatus::kTimeLimit) break;
    if (is_success(result.status)) {
      const bool both = options.stop != StopTest::kGuarded || inner.tol < options.tol ||
                        measured.natural_map <= options.tol;
      if (both) break;
      inner.tol =
          0.1 * options.tol;  // the natural map lags: the same stage kinds, ten times tighter
      last = SolveStatus::kConverged;
    }
    if (options.stop == StopTest::kGuarded && best_error <= options.tol &&
        inner.tol < options.tol) {
      break;  // the tighter attempt failed; the tolerance that was asked for is met
    }
  }
  if (options.stop == StopTest::kGuarded && best_error <= options.tol) {
    last = SolveStatus::kConverged;
  }
  // A stage that diverged or broke down leaves the best impulse of the others: the chain as a whole
  // has stalled, unless nothing better than the start was found.
  const bool broke = last == SolveStatus::kDiverged || last == SolveStatus::kNumericalFailure;
  if (broke && best_error < start_error) last = SolveStatus::kStalled;
  best.status = last;
  best.message = fmt::format("stages: {}", trail.empty() ? "none was run" : trail);
  best.iterations = iterations;
  best.setup_seconds = setup_seconds;
  best.solve_seconds = seconds_since(start) - setup_seconds;
  return best;
}

}  // namespace bipot
