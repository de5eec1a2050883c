#include "solvers/solve_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/large_pages.h"
#include "core/base/parallel.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

const SolverEntry kNoSolver{};

}  // namespace

SolveRun::SolveRun(ContactSpace& space, const SolverEntry& entry, const SolverOptions& options)
    : space_(space),
      entry_(entry),
      options_(options),
      parameters_(options.parameters, entry.parameters),
      free_energy_(space.energy_at_rest()) {
  if (space.whole() == nullptr) next_poll_ = kPolled;
}

SolveRun::SolveRun(const ContactProblem& problem, const SolverOptions& options)
    : own_space_(std::make_unique<WholeSpace>(problem, options.execution.threads)),
      space_(*own_space_),
      entry_(kNoSolver),
      options_(options),
      parameters_(options.parameters, {}),
      free_energy_(space_.energy_at_rest()) {}

bool SolveRun::due(int iteration) {
  if (every_ || options_.stop == StopTest::kImpulse || iteration >= next_ ||
      (previous_iteration_ < options_.also_judged && iteration >= options_.also_judged) ||
      iteration >= options_.max_iterations) {
    return true;
  }
  if (iteration < next_poll_) return false;
  if (space_.whole() == nullptr) next_poll_ = iteration + kPolled;
  if (out_of_time()) next_ = iteration;
  return iteration >= next_;
}

int SolveRun::undue(int iteration, int most) const {
  if (every_ || options_.stop == StopTest::kImpulse) return 1;
  const bool first = iteration < options_.also_judged && options_.also_judged < next_;
  const int judged = first ? options_.also_judged : next_;
  return std::clamp(std::min(judged, options_.max_iterations) - iteration, 1, most);
}

/// True if the impulse judged last meets the stop test; stores the best one.
bool SolveRun::accept(double impulse_change) {
  const double error = last_.guarded();
  if (error < best_error_) {
    best_error_ = error;
    best_s_ = space_.impulse();
  }
  if (options_.stop == StopTest::kImpulse) return impulse_change <= options_.tol;
  return bipot::meets(options_, last_) && space_.prove(options_, space_.impulse(), last_).holds;
}

bool SolveRun::meets(const Eigen::Ref<const Vector>& s) {
  last_ = space_.error(s);
  return accept(kInfinity);
}

/// Squared norms, over the rows of this process, of s and of its change since the iterate judged
/// before, if that is known. In pieces, so that data come from memory once.
void SolveRun::replace_previous(const Eigen::Ref<const Vector>& s, bool known, double& norm2,
                                double& change2) {
  if (previous_.size() != s.size()) previous_ = large_vector(s.size());
  const int size = static_cast<int>(s.size());
  std::vector<std::array<double, 2>> pieces(to_size((size + kPieceItems - 1) / kPieceItems));
  run_pieces(options_.execution.threads, size, [&](int first, int last) {
    const auto now = s.segment(first, last - first);
    auto before = previous_.segment(first, last - first);
    if (known) {
      pieces[to_size(first / kPieceItems)] = {now.squaredNorm(), (now - before).squaredNorm()};
    }
    before = now;
  });
  for (const auto& [now2, piece2] : pieces) {
    norm2 += now2;
    change2 += piece2;
  }
}

ContactCount SolveRun::count() {
  ContactCount count = count_contacts(problem(), space_.impulse());
  if (space_.whole() != nullptr) return count;
  double counts[3] = {1.0 * count.take_off, 1.0 * count.stick, 1.0 * count.slip};
  space_.sum(counts);
  return {static_cast<int>(counts[0]), static_cast<int>(counts[1]), static_cast<int>(counts[2])};
}

/// Looked at when the count has doubled: it costs as much as judging.
bool SolveRun::at_floor(int iteration) {
  if (iteration < next_floor_ || space_.whole() == nullptr) return false;
  next_floor_ = 2 * iteration;
  return whole().share() == ErrorShare{} &&
         at_rounding_floor(problem(), options_, space_.impulse(), last_);
}

bool SolveRun::stop(int iteration, const Eigen::Ref<const Vector>& s, double step, bool moving) {
  iterations_ = iteration;
  if (!due(iteration)) return false;
  next_ = next_judged(iteration, portion_, roots_);

  const bool known =
      previous_.size() == s.size() && previous_iteration_ >= 0 && previous_iteration_ < iteration;
  const bool comparable = previous_iteration_ >= 0 && previous_iteration_ == iteration - 1;
  double exact_norm2 = 0, exact_change2 = 0;
  const bool exact = space_.exact();
  if (exact && known) {
    exact_norm2 = space_.dot(s, s);
    exact_change2 = space_.dot(s - previous_, s - previous_);
  }
  // In parallel the norms and the wishes to stop are added up with the criterion's sums.
  const bool alone = space_.whole() != nullptr;
  double more[4] = {0, 0, !alone && cancelled_here() ? 1.0 : 0.0,
                    !alone && late_here() ? 1.0 : 0.0};
  replace_previous(s, known, more[0], more[1]);
  last_ = space_.error(s, more);
  const double norm2 = exact ? exact_norm2 : more[0];
  const double change2 = exact ? exact_change2 : more[1];
  // Two iterates at 0 give 0/0. (0 is no solution here, or solve() would have returned it.)
  const double change = known && norm2 > 0 ? std::sqrt(change2 / norm2) : kInfinity;
  const bool met = accept(comparable ? change : kInfinity);

  if (options_.on_iteration) {
    options_.on_iteration({.iteration = iteration,
                           .seconds = seconds(),
                           .error = last_,
                           .step = step,
                           .count = [this] { return count(); }});
  }
  free_energy_ = divergence_reference(iteration, last_, free_energy_);
  if (met) {
    best_s_ = space_.impulse();
    best_error_ = last_.guarded();
  }
  JudgedIterate::Verdict verdict = stop_verdict(options_, {.iteration = iteration,
                                                           .error = last_,
                                                           .best_error = best_error_,
                                                           .free_energy = free_energy_,
                                                           .change = change,
                                                           .moving = moving,
                                                           .met = met});
  if (verdict.status == SolveStatus::kNotRun && at_floor(iteration)) {
    verdict = {SolveStatus::kStalled, fmt::format("stalled at iteration {}", iteration)};
  }
  if (verdict.status == SolveStatus::kNotRun) {
    verdict = out_of_time_verdict(options_, alone ? cancelled_here() : more[2] > 0,
                                  alone ? late_here() : more[3] > 0, iteration, best_error_);
  }
  if (verdict.status != SolveStatus::kNotRun) end(verdict.status, std::move(verdict.message));
  previous_iteration_ = iteration;
  return status_ != SolveStatus::kNotRun;
}

void SolveRun::end(SolveStatus status, std::string message) {
  status_ = status;
  message_ = std::move(message);
}

bool SolveRun::end_if_out_of_time(int iteration) {
  JudgedIterate::Verdict verdict =
      out_of_time_verdict(options_, cancelled(), late(), iteration, best_error_);
  if (verdict.status == SolveStatus::kNotRun) return false;
  end(verdict.status, std::move(verdict.message));
  return true;
}

bool SolveRun::cancelled() { return space_.any(cancelled_here()); }

bool SolveRun::late() { return space_.any(late_here()); }

bool SolveRun::out_of_time() { return space_.any(cancelled_here() || late_here()); }

double SolveRun::remaining_seconds() const {
  return std::max(1e-9, options_.time_limit - seconds());
}

const Vector& SolveRun::best_impulse() {
  if (best_s_.size() != problem().num_rows()) {
    best_s_ = large_vector(problem().num_rows());
    best_s_.setZero();
  }
  return best_s_;
}

SolveResult SolveRun::nested(const SolverEntry& entry, const SolverOptions& options,
                             const ErrorShare& share) {
  return run_solver(entry, space_, options, share, factor_);
}

SolveResult SolveRun::nested(std::string_view solver, double tol, int max_iterations, Vector s0) {
  return nested(require_solver(solver), {.tol = tol,
                                         .max_iterations = max_iterations,
                                         .time_limit = remaining_seconds(),
                                         .s0 = std::move(s0),
                                         .cancelled = options_.cancelled});
}

void SolveRun::perform() {
  try {
    entry_.run(*this);
  } catch (const FactorStopped&) {
    if (!end_if_out_of_time(iterations_)) throw;
  } catch (const std::bad_alloc& e) {
    if (space_.whole() == nullptr) throw;  // the other processes would wait
    const std::string_view said = e.what();
    end(SolveStatus::kNumericalFailure,
        fmt::format("{}; {} iterations, best error {:.2e}",
                    said.starts_with("out of memory") ? said : "out of memory", iterations_,
                    best_error_));
  }
}

SolveResult SolveRun::finish() {
  if (taken_) return *std::move(taken_);
  return SolveResult{.status = status_,
                     .message = message_ + remarks_,
                     .s = best_impulse(),
                     .iterations = iterations_,
                     .setup_seconds = setup_seconds_,
                     .solve_seconds = seconds() - setup_seconds_};
}

SolveResult run_solver(const SolverEntry& entry, ContactSpace& space, const SolverOptions& options,
                       const ErrorShare& share, SystemFactor* factor) {
  const auto in = [&](ContactSpace& where) {
    SolveRun run(where, entry, options);
    run.set_factor(factor);
    run.perform();
    return run.finish();
  };
  if (space.whole() == nullptr) {
    return runs_on_parts(entry, options) == Parallel::kNo ? space.solve_on_root(entry, options)
                                                          : in(space);
  }
  if (space.whole()->share() == share) return in(space);
  WholeSpace own(*space.whole(), share);
  return in(own);
}

SolveResult run_solver(const SolverEntry& entry, const ContactProblem& problem,
                       const SolverOptions& options) {
  WholeSpace space(problem, options.execution.threads);
  return run_solver(entry, space, options);
}

std::function<void(const IterationRecord&)> history_after(const SolverOptions& options,
                                                          int iterations, double seconds,
                                                          bool with_start) {
  if (!options.on_iteration) return nullptr;
  return [=, &options](IterationRecord record) {
    if (record.iteration == 0 && !with_start) return;
    record.iteration += iterations;
    record.seconds += seconds;
    options.on_iteration(record);
  };
}

Parallel runs_on_parts(const SolverEntry& entry, const SolverOptions& options) {
  if (entry.parallel == nullptr) return Parallel::kNo;
  return entry.parallel(Parameters(options.parameters, entry.parameters));
}

void require_common(ContactSpace& space, const std::exception& failure) {
  if (space.whole() == nullptr && dynamic_cast<const CommonFailure*>(&failure) == nullptr) throw;
}

std::function<void(SolveRun&)> run_of(
    std::function<SolveResult(const ContactProblem&, const SolverOptions&)> solver) {
  return [solver = std::move(solver)](SolveRun& run) {
    run.take(solver(run.problem(), run.options()));
  };
}

}  // namespace bipot
