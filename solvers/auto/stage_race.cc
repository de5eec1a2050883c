#include "solvers/auto/stage_race.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <optional>
#include <string>

#include "core/base/release.h"
#include "core/base/stopwatch.h"
#include "core/criterion/contact_error.h"

namespace bipot {
namespace {

// constant          value   unit          reason
// kNearTolerances   10      tolerances    an error within a decade mostly arrives soon
// kOvertime         1.25    budgets       for a stage that is near and will arrive by then; not from
//                                         a warm start: what sweeps leave makes next steps harder
// kFreedFrom        6000    contacts      memory counts more than the milliseconds to give it back
constexpr double kNearTolerances = 10;
constexpr double kOvertime = 1.25;
constexpr int kFreedFrom = 6000;

/// Whether a stage will reach the tolerance within its budget, from the errors that it showed so
/// far: the decades gained since half as many iterations are carried forward.
class Forecast {
 public:
  Forecast(const AutoStage& stage, double tol, StopTest stop, bool warm)
      : stage_(stage), tol_(tol), stop_(stop), warm_(warm) {}

  void record(const IterationRecord& r) {
    if (failed_) return;
    // The difference of successive impulses is not in the record: there is no forecast for it.
    if (stop_ == StopTest::kImpulse || stage_.max_iterations == AutoStage::kUnlimited) return;
    double error = r.error.guarded();
    if (stop_ == StopTest::kRaw42 && std::isfinite(r.error.raw42)) error = r.error.raw42;
    if (!best_.empty()) error = std::min(error, best_.rbegin()->second);
    if (!std::isfinite(error)) {
      failed_ = r.iteration >= stage_.max_iterations;
      return;
    }
    best_[r.iteration] = error;
    if (r.iteration < std::max(stage_.min_iterations, 2)) return;
    const bool near = error <= kNearTolerances * tol_;
    if (near && r.iteration < stage_.near_iterations) return;
    auto half = best_.upper_bound(r.iteration / 2);
    if (half != best_.begin()) --half;
    const double gained = std::log(half->second / error), needed = std::log(error / tol_);
    const double left = needed / gained * (r.iteration - half->first);  // inf: no gain
    const bool overtime = near && r.iteration >= stage_.max_iterations;
    failed_ = !(r.iteration + left <= (overtime ? budget() : stage_.max_iterations));
  }
  bool failed() const { return failed_; }

  /// Of iterations, overtime included.
  double budget() const {
    const bool more = stop_ != StopTest::kImpulse && !warm_;
    return (more ? kOvertime : 1) * stage_.max_iterations;
  }

 private:
  const AutoStage& stage_;
  const double tol_;
  const StopTest stop_;
  const bool warm_;
  std::map<int, double> best_;  // error so far, by iteration
  bool failed_ = false;
};

/// The stages in progress.
class Race {
 public:
  Race(SolveRun& run, const Vector& best)
      : run_(run),
        p_(run.problem()),
        options_(run.options()),
        space_(run.space()),
        inner_(options_) {
    inner_.s0 = Vector();  // of the stages: their own
    best_.s = run.start();
    judged_ = space_.error(best_.s);
    best_error_ = judged_.guarded();
    if (std::isnan(best_error_)) best_error_ = kInfinity;
    start_error_ = best_error_;
    goes_on_ = best.size() != 0;
    if (!goes_on_) return;
    const ContactError error = space_.error(best);
    if (error.guarded() < best_error_) {
      best_.s = best;
      judged_ = error;
      best_error_ = error.guarded();
    }
  }

  SolveResult run(std::span<const AutoStage> stages,
                  const std::function<bool(const AutoStage&)>& chosen) {
    bool any = false;
    for (const AutoStage& stage : stages) {
      if (!chosen(stage)) continue;
      any = true;
      if (finished(stage)) break;
    }
    return any || goes_on_ ? finish() : SolveResult();
  }

 private:
  bool alone() { return space_.whole() != nullptr; }

  /// Runs the stage; true if none is to follow.
  bool finished(const AutoStage& stage) {
    if (out_of_budget()) return true;
    if (best_error_ > stage.largest_error) return false;
    run_stage(stage);
    return ended_ || is_success(last_) || at_floor();
  }

  /// True if the best impulse is as exact as doubles allow: no further stages.
  bool at_floor() {
    if (!alone() || !std::isfinite(best_error_) || !(run_.whole().share() == ErrorShare{}) ||
        !at_rounding_floor(p_, options_, best_.s, judged_)) {
      return false;
    }
    last_ = SolveStatus::kStalled;
    return true;
  }

  bool out_of_budget() {
    if (run_.late()) {
      last_ = SolveStatus::kTimeLimit;
    } else if (iterations_ >= options_.max_iterations) {
      last_ = SolveStatus::kIterationLimit;
    } else {
      return false;
    }
    return true;
  }

  void run_stage(const AutoStage& stage) {
    auto own = own_.find(stage.solver->name);
    if (stage.start == AutoStage::Start::kBest) {
      inner_.s0 = best_.s;
    } else if (stage.start == AutoStage::Start::kLast && last_s_.size() != 0) {
      inner_.s0 = last_s_;
    } else if (stage.start == AutoStage::Start::kCaller) {
      inner_.s0 = options_.s0;
    } else {
      inner_.s0 = own != own_.end() ? own->second : options_.s0;
    }
    inner_.s0 *= stage.of_start;
    inner_.time_limit = run_.remaining_seconds();
    inner_.parameters = stage_parameters(stage.parameters);
    Forecast forecast(stage, inner_.tol, options_.stop, is_warm(options_));
    const double allowed = options_.max_iterations - iterations_;
    inner_.max_iterations = static_cast<int>(std::min(forecast.budget(), allowed));
    inner_.also_judged = stage.max_iterations;
    const auto history = history_after(options_, iterations_, run_.seconds(), trail_.empty());
    inner_.on_iteration = [&](const IterationRecord& r) {
      forecast.record(r);
      if (history) history(r);
    };
    inner_.cancelled = [&] {
      return forecast.failed() || (options_.cancelled && options_.cancelled());
    };
    SolveResult result;
    // Memory of the previous stage is fragmented for the next one's arrays.
    if (!trail_.empty() && p_.num_contacts() > kFreedFrom) return_freed_memory();
    try {
      const SolverEntry& entry = *stage.solver;
      const bool lacks_delassus = alone() && entry.needs_delassus && !p_.has_delassus();
      const ErrorShare share = alone() ? run_.whole().share() : ErrorShare{};
      result = lacks_delassus ? run_solver(entry, with_delassus(), inner_, share)
                              : run_.nested(entry, inner_, share);
    } catch (const std::exception& e) {
      require_common(space_, e);
      result.status = SolveStatus::kNumericalFailure;
      result.message = e.what();
    }
    iterations_ += result.iterations;
    best_.setup_seconds += result.setup_seconds;
    last_ = result.status;
    double error = kInfinity;
    ContactError judged;
    if (!space_.any(result.s.size() != p_.num_rows() || !result.s.allFinite())) {
      judged = space_.error(result.s);
      error = judged.guarded();
      own_.insert_or_assign(std::string(stage.solver->name), result.s);
      last_s_ = result.s;
    }
    // W rounds otherwise than A and H: an impulse that meets the tolerance with the one may miss it
    // with the others, and the stages continue.
    if (is_success(last_) && options_.stop == StopTest::kGuarded && !(error <= inner_.tol)) {
      last_ = SolveStatus::kStalled;
    }
    // Loops inside a solver do not distinguish a stop from the end of their time.
    const bool stopped = last_ == SolveStatus::kInterrupted || last_ == SolveStatus::kTimeLimit;
    const bool by_caller = stopped && run_.cancelled();
    // One process alone knows the records of a stage that runs on it: all must decide alike.
    const bool given_up = stopped && !by_caller && space_.any(forecast.failed()) && !run_.late();
    if (by_caller) last_ = SolveStatus::kInterrupted;
    if (given_up) last_ = SolveStatus::kIterationLimit;
    const bool early = given_up && result.iterations < stage.max_iterations;
    trail_ += fmt::format("{}{} {}: {} ({:.1e})", trail_.empty() ? "" : "; ", stage.solver->name,
                          result.iterations, early ? "given up" : to_string(last_), error);
    if (error < best_error_ || is_success(last_)) {
      judged_ = judged;
      best_error_ = error;
      best_.s = result.s;
    }
    ended_ = stopped && !given_up;
  }

  /// The problem with W, assembled by the first stage that needs it.
  WholeSpace& with_delassus() {
    if (!delassus_space_) {
      const Stopwatch setup;
      with_delassus_ = p_;
      with_delassus_.W = assemble_delassus(p_.A, p_.H, p_.dim);
      delassus_space_.emplace(with_delassus_, options_.execution.threads);
      best_.setup_seconds += setup.seconds();
    }
    return *delassus_space_;
  }

  SolveResult finish() {
    if (options_.stop == StopTest::kGuarded && best_error_ <= options_.tol) {
      last_ = SolveStatus::kConverged;
    }
    // After a stage that diverged or failed the best impulse is that of the others. The solve as a
    // whole has stalled, unless nothing better than the start was found.
    const bool broke = last_ == SolveStatus::kDiverged || last_ == SolveStatus::kNumericalFailure;
    if (broke && best_error_ < start_error_) last_ = SolveStatus::kStalled;
    best_.status = last_;
    best_.message = fmt::format("stages: {}", trail_.empty() ? "none was run" : trail_);
    best_.iterations = iterations_;
    best_.solve_seconds = run_.seconds() - best_.setup_seconds;
    return std::move(best_);
  }

  SolveRun& run_;
  const ContactProblem& p_;
  const SolverOptions& options_;
  ContactProblem with_delassus_;
  std::optional<WholeSpace> delassus_space_;  // of that
  ContactSpace& space_;
  SolverOptions inner_;
  SolveResult best_;
  std::map<std::string, Vector, std::less<>> own_;
  Vector last_s_;        // of the last stage
  ContactError judged_;  // of best_.s
  double best_error_ = 0, start_error_ = 0;
  int iterations_ = 0;
  SolveStatus last_ = SolveStatus::kIterationLimit;
  bool ended_ = false;    // by the caller or the clock
  bool goes_on_ = false;  // from an attempt
  std::string trail_;
};

}  // namespace

SolveResult race_stages(SolveRun& run, std::span<const AutoStage> stages, const Vector& best,
                        const std::function<bool(const AutoStage&)>& chosen) {
  return Race(run, best).run(stages, chosen);
}

}  // namespace bipot
