#include "solvers/solve.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/linear/dense_buffer.h"
#include "core/problem/delassus.h"
#include "solvers/parameters.h"
#include "solvers/registry.h"
#include "solvers/solve_run.h"
#include "solvers/stop_rule.h"

namespace bipot {
namespace {

SolveResult refuse(std::string message) {
  return SolveResult{.status = SolveStatus::kInvalidInput, .message = std::move(message)};
}

/// Judges result.s and writes s, u and error. Withdraws false claims, and those that only the
/// rounding of the criterion supports.
void judge(ContactSpace& space, const SolverOptions& options, SolveResult& result) {
  const Eigen::Index rows = space.problem().num_rows();
  if (space.any(result.s.size() != rows)) {
    result.message = fmt::format("the solver returned {} rows, expected {} (it said: {})",
                                 result.s.size(), rows, result.message);
    result.status = SolveStatus::kNumericalFailure;
    result.s = Vector::Zero(rows);
  } else if (space.any(!result.s.allFinite())) {
    result.message =
        fmt::format("the solver returned a non-finite impulse (it said: {})", result.message);
    result.status = SolveStatus::kNumericalFailure;
    result.s = Vector::Zero(rows);
  }
  result.error = space.error(result.s);
  space.find_worst(result.error);
  result.s = space.impulse();
  result.u = space.impulse_velocity();

  // Without contacts or violation the raw (42) is 0/0: that claim is judged by the guarded error.
  const bool raw = options.stop == StopTest::kRaw42 && result.status == SolveStatus::kConverged;
  const double measured = raw ? result.error.raw42 : result.error.guarded();
  const bool verifiable =
      options.stop != StopTest::kImpulse || result.status == SolveStatus::kNothingToDo;
  if (is_success(result.status) && verifiable && !(measured <= options.tol)) {
    result.message = fmt::format(
        "claim of convergence withdrawn: {} error {:.3e} on the original data, tolerance {} "
        "(it said: {})",
        raw ? "raw42" : "guarded", measured, tolerance_label(options.tol), result.message);
    result.status = SolveStatus::kNumericalFailure;
  } else if (result.status == SolveStatus::kNotRun) {
    result.message = "the solver returned without a status";
    result.status = SolveStatus::kNumericalFailure;
  }
  const bool unsolved = !is_success(result.status) && result.status != SolveStatus::kInterrupted &&
                        result.status != SolveStatus::kTimeLimit;
  if (unsolved && space.whole() != nullptr &&
      at_rounding_floor(space.problem(), options, result.s, result.error)) {
    result.status = SolveStatus::kStalled;
    result.message = fmt::format("as exact as doubles allow: {:.0e}; {}", result.error.guarded(),
                                 result.message);
  }
  if (result.status != SolveStatus::kConverged) return;
  const ProvedClaim claim = space.prove(options, result.s, result.error);
  if (claim.holds) return;
  result.status = SolveStatus::kStalled;
  result.message = fmt::format(
      "stalled at rounding: guarded error {:.3e} in double, {:.3e} in extended precision (it said: "
      "{})",
      result.error.guarded(), claim.error, result.message);
}

/// A run of the solver; failures become a status.
SolveResult run(ContactSpace& space, const SolverEntry& entry, const SolverOptions& options) {
  SolveResult result;
  const auto failed = [&](std::string words) {
    result.status = SolveStatus::kNumericalFailure;
    result.message = fmt::format("{} failed{}", entry.name, words);
    result.s = Vector::Zero(space.problem().num_rows());
  };
  try {
    result = run_solver(entry, space, options);
  } catch (const std::invalid_argument& e) {  // options that do not fit the problem
    require_common(space, e);
    result = refuse(fmt::format("solver {}: {}", entry.name, e.what()));
    result.s = Vector::Zero(space.problem().num_rows());
  } catch (const std::exception& e) {
    require_common(space, e);
    failed(fmt::format(": {}", e.what()));
  } catch (...) {
    if (space.whole() == nullptr) throw;
    failed(" with something that is no exception");
  }
  return result;
}

/// The power of two that brings the free motion's energies u²/W_nn near 1 if their squares overflow
/// or underflow; 0 for all but extreme data. Exact: the law is homogeneous.
int velocity_exponent(const ContactProblem& p) {
  constexpr int kSafe = 800;  // of 1022 binary decades
  bool any = false;
  int highest = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Eigen::Index row = static_cast<Eigen::Index>(c) * p.dim;
    const double u = p.u_free.segment(row, p.dim).cwiseAbs().maxCoeff();
    if (u == 0) continue;
    double w = 0;
    if (p.has_delassus()) {
      w = p.W.coeff(row, row);
    } else {
      for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
        w += it.value() * it.value() / p.A.coeff(it.row(), it.row());
      }
    }
    const int energy = 2 * std::ilogb(u) - std::ilogb(w);
    highest = any ? std::max(highest, energy) : energy;
    any = true;
  }
  return std::abs(highest) <= kSafe ? 0 : -highest / 2;
}

/// Solves the problem with all velocities and impulses times 2^exponent, and converts the result
/// back.
SolveResult solve_in_other_units(const SolverEntry& entry, ContactProblem problem,
                                 SolverOptions options, int exponent) {
  const auto scale = [](Vector& x, int by) {
    for (double& value : x) value = std::ldexp(value, by);
  };
  scale(problem.u_free, exponent);
  scale(problem.v_free, exponent);
  scale(options.s0, exponent);
  SolveResult result = solve(entry, problem, options);
  scale(result.s, -exponent);
  scale(result.u, -exponent);
  for (double* energy : {&result.error.energy, &result.error.friction_power}) {
    *energy = std::ldexp(*energy, -2 * exponent);
  }
  return result;
}

/// Takes the common parameter out of the solver's own.
SolveResult solve_with_islands_as_named(const SolverEntry& entry, const ContactProblem& problem,
                                        SolverOptions options) {
  const std::string name(kIslandsParameter.name);
  const std::map<std::string, std::string> named{{name, options.parameters[name]}};
  options.parameters.erase(name);
  try {
    const std::span<const ParameterSpec> spec(&kIslandsParameter, 1);
    options.islands = Parameters(named, spec).choice(name) == "on";
  } catch (const std::invalid_argument& e) {
    return refuse(fmt::format("solver {}: {}", entry.name, e.what()));
  }
  return solve(entry, problem, std::move(options));
}

/// True if the entry reads SolverOptions::islands itself.
bool looks_at_islands(const SolverEntry& entry) {
  return std::any_of(entry.parameters.begin(), entry.parameters.end(),
                     [](const ParameterSpec& s) { return s.name == kIslandsParameter.name; });
}

}  // namespace

std::string refusal(const SolverEntry& entry, const ContactProblem& p, const SolverOptions& o) {
  if (auto defect = validate(p); !defect.empty()) return defect;
  if (!(o.tol > 0) || !std::isfinite(o.tol)) {
    return fmt::format("tol = {}, expected a positive finite number", o.tol);
  }
  if (o.max_iterations < 0) {
    return fmt::format("max_iterations = {}, expected >= 0", o.max_iterations);
  }
  if (o.execution.threads < 1) {
    return fmt::format("threads = {}, expected >= 1", o.execution.threads);
  }
  if (!has_path(o.execution.path)) {
    return fmt::format("this machine has no {}", to_string(o.execution.path));
  }
  if (!(o.time_limit > 0)) return fmt::format("time_limit = {} s, expected > 0", o.time_limit);
  if (o.s0.size() != 0 && o.s0.size() != p.num_rows()) {
    return fmt::format("start s0 has size {}, expected {}", o.s0.size(), p.num_rows());
  }
  if (!o.s0.allFinite()) return "start s0 has a non-finite entry";
  if (o.islands.value_or(false) && o.stop != StopTest::kGuarded) {
    return "islands = on goes with the guarded stop test alone";
  }
  try {
    Parameters(o.parameters, entry.parameters);
  } catch (const std::invalid_argument& e) {
    return fmt::format("solver {}: {}", entry.name, e.what());
  }
  return beyond_solver(entry, p);
}

SolveResult solve_in(ContactSpace& space, const SolverEntry& entry, const SolverOptions& options,
                     const Stopwatch& watch) {
  SolveResult result{.s = Vector::Zero(space.problem().num_rows())};
  const ContactError none = space.error(result.s);
  std::optional<ContactError> start;
  if (space.any(options.s0.size() != 0) && none.guarded() != 0) {
    start = space.error(start_of(space.problem(), options));
  }
  if (none.guarded() == 0) {
    result.status = SolveStatus::kNothingToDo;
    result.message = space.whole_contacts() == 0 ? "no contacts" : "s = 0 satisfies the law";
  } else if (start && meets(options, *start) &&
             space.prove(options, space.impulse(), *start).holds) {
    result.status = SolveStatus::kConverged;
    result.message = "the start meets the stop test";
    result.s = start_of(space.problem(), options);
  } else {
    const double before = watch.seconds();
    space.release_scratch();  // until the solver judges
    result.s = Vector();
    const auto run_with = [&](const SolverOptions& how) { result = run(space, entry, how); };
    // Impulses of jammed bodies at rest in the previous step may be huge beside this one: no solver
    // recovers from there with significant digits.
    if (start && !(start->energy <= kDivergenceFactor * none.energy)) {  // NaN: beyond all numbers
      SolverOptions from_zero = options;
      from_zero.s0 = Vector();
      run_with(from_zero);
    } else {
      run_with(options);
    }
    result.setup_seconds += before;
  }
  if (result.status != SolveStatus::kInvalidInput) judge(space, options, result);
  return result;
}

SolveResult solve(std::string_view solver, const ContactProblem& problem, SolverOptions options) {
  const SolverEntry* entry = find_solver(solver);
  if (entry == nullptr) return refuse(unknown_solver_message(solver));
  return solve(*entry, problem, std::move(options));
}

SolveResult solve(const SolverEntry& given_entry, const ContactProblem& problem,
                  SolverOptions options) {
  if (options.parameters.count(std::string(kIslandsParameter.name)) > 0) {
    return solve_with_islands_as_named(given_entry, problem, std::move(options));
  }
  if (auto defect = refusal(given_entry, problem, options); !defect.empty()) {
    return refuse(std::move(defect));
  }
  if (const int exponent = velocity_exponent(problem); exponent != 0) {
    return solve_in_other_units(given_entry, problem, std::move(options), exponent);
  }
  try {
    take_dense_buffer();
    const Stopwatch watch;
    const bool cut = options.islands.value_or(false) && !looks_at_islands(given_entry);
    const SolverEntry entry = cut ? on_islands(given_entry) : given_entry;
    const ContactProblem* given = &problem;
    ContactProblem with_delassus;
    // With a general A the operator is W itself: assembled once for this solve.
    const bool can_assemble = !problem.has_delassus() && problem.has_velocities();
    if (can_assemble && (entry.needs_delassus || !is_diagonal(problem.A))) {
      with_delassus = problem;
      with_delassus.W = assemble_delassus(problem.A, problem.H, problem.dim);
      given = &with_delassus;
    }
    WholeSpace space(*given, options.execution.threads);
    return solve_in(space, entry, options, watch);
  } catch (const std::exception& e) {  // out of memory, an indefinite general mass matrix
    return SolveResult{.status = SolveStatus::kNumericalFailure,
                       .message = e.what(),
                       .s = Vector::Zero(problem.num_rows()),
                       .u = problem.u_free};
  }
}

}  // namespace bipot
