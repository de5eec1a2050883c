#include "solvers/auto/auto_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/release.h"
#include "core/base/stopwatch.h"
#include "core/criterion/contact_error.h"
#include "solvers/auto/auto_plan.h"
#include "solvers/auto/islands.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

// An error that is that many tolerances is let go on, at loose tolerances for the iterations that the
// stage has for it.
constexpr double kClose = 10, kLooseTolerance = 3e-4;
// Contacts from which on memory counts more than the milliseconds that it takes to give it back.
constexpr int kLargeRun = 6000;

/// Whether a stage is still worth its time, from the errors that it showed so far.
class Promise {
 public:
  Promise(const AutoStage& stage, double tol, StopTest stop)
      : first_(stage.min_iterations),
        last_(stage.max_iterations),
        close_(tol >= kLooseTolerance ? stage.close_iterations : stage.max_iterations),
        tol_(tol),
        stop_(stop) {}

  void record(const IterationRecord& r) {
    // The difference of successive impulses is not in the record: nothing is predicted from it.
    if (stop_ == StopTest::kImpulse || last_ == AutoStage::kUnlimited) return;
    double error = r.error.guarded();
    if (stop_ == StopTest::kRaw42 && std::isfinite(r.error.raw42)) error = r.error.raw42;
    if (!history_.empty()) error = std::min(error, history_.back().error);
    if (!std::isfinite(error)) return;
    history_.push_back({r.iteration, error});
    if (r.iteration < std::max(first_, 2)) return;
    if (error <= kClose * tol_ && r.iteration < close_) return;  // so close, it would be a pity
    // Decades gained since half as many iterations.
    auto half = std::upper_bound(history_.begin(), history_.end(), r.iteration / 2,
                                 [](int k, const Entry& e) { return k < e.iteration; });
    if (half != history_.begin()) --half;
    const double gained = std::log(half->error / error);
    const double needed = std::log(error / tol_);
    const double left = needed / gained * (r.iteration - half->iteration);  // inf: no gain
    broken_ = !(r.iteration + left <= last_);
  }
  bool broken() const { return broken_; }

 private:
  struct Entry {
    int iteration;
    double error;
  };
  int first_, last_, close_;
  double tol_;
  StopTest stop_;
  std::vector<Entry> history_;
  bool broken_ = false;
};

/// The race on several processes: rounds of first order, each from the best impulse so far, with a
/// budget that doubles from round to round; after the third, and after every third from there on, one
/// of second order on the first process.
std::vector<AutoStage> plan_in_parallel() {
  constexpr int kFirstBudget = 512, kRounds = 16, kRoundsToSecondOrder = 3;
  const auto stage = [](std::string_view solver, int budget, std::string_view reason) {
    AutoStage made{solver, budget, budget};
    made.start = AutoStage::Start::kBest;
    made.reason = reason;
    return made;
  };
  std::vector<AutoStage> stages;
  for (int round = 0; round < kRounds; ++round) {
    const int budget = kFirstBudget << round;
    for (const std::string_view solver : {"apgd", "anderson", "pgs"}) {
      stages.push_back(stage(solver, budget, "rounds of first order"));
    }
    if ((round + 1) % kRoundsToSecondOrder == 0) {
      stages.push_back(stage("ipm", AutoStage::kUnlimited, "where they do not arrive"));
    }
  }
  stages.push_back(stage("pgs", AutoStage::kUnlimited, "last resort"));
  return stages;
}

/// The race in progress.
class Race {
 public:
  /// `attempted`: the impulse that an attempt left, whose first stage is not run again; or empty.
  Race(SolveRun& run, const Vector& attempted)
      : run_(run),
        p_(run.problem()),
        options_(run.options()),
        space_(run.space()),
        inner_(options_),
        attempted_(attempted.size() != 0) {
    inner_.s0 = Vector();  // of the stages: their own
    best_.s = run.start();
    best_error_ = space_.error(best_.s).guarded();
    if (std::isnan(best_error_)) best_error_ = std::numeric_limits<double>::infinity();
    start_error_ = best_error_;
    if (!attempted_) return;
    const double error = space_.error(attempted).guarded();
    if (error < best_error_) {
      best_.s = attempted;
      best_error_ = error;
    }
  }

  SolveResult run() {
    race([&](const AutoStage& stage) { return !(attempted_ && stage.on_whole_only); });
    return finish();
  }

  SolveResult attempt() {
    race([](const AutoStage& stage) { return stage.before_cutting; });
    return trail_.empty() ? SolveResult() : finish();
  }

 private:
  /// The stages that `chosen` takes, one after the other.
  template <class Chosen>
  void race(const Chosen& chosen) {
    // On a handful of contacts the plan would cost more than the solution.
    const bool few = alone() && p_.num_contacts() <= kFewContactsOfAuto;
    if (few) {
      const AutoStage first = first_of_few(p_, run_.delassus());
      if (chosen(first) && finished(first)) return;
    }
    const std::vector<AutoStage> stages =
        alone() ? plan_auto(p_, run_.delassus(), is_warm(options_)) : plan_in_parallel();
    for (std::size_t k = few ? 1 : 0; k < stages.size(); ++k) {
      keep_only_what_serves(std::span(stages).subspan(k));
      if (chosen(stages[k]) && finished(stages[k])) return;
    }
  }

  /// Drops the impulses that none of the stages to come begins with.
  void keep_only_what_serves(std::span<const AutoStage> coming) {
    std::erase_if(own_, [&](const auto& of) {
      return std::none_of(coming.begin(), coming.end(), [&](const AutoStage& stage) {
        return stage.start == AutoStage::Start::kOwn && stage.solver == of.first;
      });
    });
    const bool last_serves = std::any_of(coming.begin(), coming.end(), [](const AutoStage& stage) {
      return stage.start == AutoStage::Start::kLast;
    });
    if (!last_serves) last_s_ = Vector();
  }

  bool alone() { return space_.whole() != nullptr; }

  /// Runs the stage; true when nothing is to follow.
  bool finished(const AutoStage& stage) {
    if (out_of_budget()) return true;
    if (!stage.serves(options_.tol, best_error_)) return false;
    run_stage(stage);
    if (alone() && !ended_ && is_success(last_) && options_.stop == StopTest::kGuarded &&
        best_natural_map_ > options_.tol) {
      tighten(stage);
    }
    return ended_ || is_success(last_);
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
    auto own = own_.find(stage.solver);
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
    inner_.time_limit = std::max(options_.time_limit - run_.seconds(), 1e-9);
    inner_.max_iterations = std::min(stage.max_iterations, options_.max_iterations - iterations_);
    inner_.parameters = stage.parameters;
    Promise promise(stage, inner_.tol, options_.stop);
    const double stage_start = run_.seconds();
    inner_.on_iteration = [&](const IterationRecord& r) {
      promise.record(r);
      if (!options_.on_iteration || (iterations_ > 0 && r.iteration == 0)) return;
      IterationRecord shifted = r;
      shifted.iteration += iterations_;
      shifted.seconds += stage_start;
      options_.on_iteration(shifted);
    };
    inner_.cancelled = [&] {
      return promise.broken() || (options_.cancelled && options_.cancelled());
    };
    SolveResult result;
    space_.rest();
    // What the stage before has left is in pieces that the next one's arrays do not fit into.
    if (!trail_.empty() && p_.num_contacts() > kLargeRun) return_freed_memory();
    try {
      const SolverEntry& entry = require_solver(stage.solver);
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
    double error = std::numeric_limits<double>::infinity();
    ContactError measured;
    if (!space_.any(result.s.size() != p_.num_rows() || !result.s.allFinite())) {
      measured = space_.error(result.s);
      error = measured.guarded();
      own_.insert_or_assign(std::string(stage.solver), result.s);
      last_s_ = result.s;
    }
    // W rounds otherwise than A and H: what meets the tolerance with the one may miss it with the
    // others, and the race goes on.
    if (is_success(last_) && options_.stop == StopTest::kGuarded && !(error <= inner_.tol)) {
      last_ = SolveStatus::kStalled;
    }
    // Loops inside a solver see no difference between being stopped and being out of time.
    const bool stopped = last_ == SolveStatus::kInterrupted || last_ == SolveStatus::kTimeLimit;
    const bool by_caller = stopped && run_.cancelled();
    const bool given_up = stopped && !by_caller && promise.broken() && !run_.late();
    if (by_caller) last_ = SolveStatus::kInterrupted;
    trail_ += fmt::format("{}{} {}: {} ({:.1e})", trail_.empty() ? "" : "; ", stage.solver,
                          result.iterations, given_up ? "given up" : to_string(last_), error);
    if (given_up) last_ = SolveStatus::kIterationLimit;
    if (error < best_error_ || is_success(last_)) {
      best_error_ = error;
      best_natural_map_ = measured.natural_map;
      best_.s = result.s;
    }
    ended_ = stopped && !given_up;
  }

  /// The problem with W in it, assembled by the first stage that needs it.
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

  /// The natural map lags behind: on to a ten times smaller error.
  void tighten(const AutoStage& successful) {
    inner_.tol = 0.1 * options_.tol;
    const SolveStatus reached = last_;
    AutoStage more = successful;
    more.start = AutoStage::Start::kBest;
    more.max_iterations = std::max(100, std::min(successful.max_iterations, 4000));
    more.min_iterations = more.max_iterations / 2;
    for (const std::string_view solver :
         {successful.solver, std::string_view("newton"), std::string_view("ipm")}) {
      if (find_solver(solver) == nullptr || out_of_budget()) continue;
      more.solver = solver;
      if (solver != successful.solver) {
        more.min_iterations = more.max_iterations = 40;
        more.parameters.clear();
      }
      run_stage(more);
      if (ended_ || best_natural_map_ <= options_.tol) break;
    }
    last_ = reached;  // whatever became of the tighter attempts
  }

  SolveResult finish() {
    if (options_.stop == StopTest::kGuarded && best_error_ <= options_.tol) {
      last_ = SolveStatus::kConverged;
    }
    // A stage that diverged or broke down leaves the best impulse of the others: the race as a
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
  bool attempted_;
  SolveResult best_;
  std::map<std::string, Vector, std::less<>> own_;
  Vector last_s_;  // of the last stage
  double best_error_ = 0, start_error_ = 0;
  double best_natural_map_ = std::numeric_limits<double>::infinity();
  int iterations_ = 0;
  SolveStatus last_ = SolveStatus::kIterationLimit;
  bool ended_ = false;  // by the caller or the clock
  std::string trail_;
};

}  // namespace

void run_race(SolveRun& run, const Vector& attempted) { run.take(Race(run, attempted).run()); }

void attempt_race(SolveRun& run) { run.take(Race(run, Vector()).attempt()); }

void solve_auto(SolveRun& run) {
  const bool islands = run.space().whole() != nullptr && run.options().islands.value_or(true);
  if (!islands) return run_race(run, Vector());
  solve_islands(run, {.run = &run_race, .attempt = &attempt_race});
}

}  // namespace bipot
