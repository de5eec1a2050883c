#include "solvers/monitor.h"

#include <algorithm>
#include <cmath>

#include "core/base/large_pages.h"
#include "core/base/parallel.h"
#include "solvers/prepared_problem.h"
#include "solvers/proved_claim.h"
#include "solvers/stop_rule.h"

namespace bipot {

IterationMonitor::IterationMonitor(const ContactProblem& problem, const SolverOptions& options,
                                   const Stopwatch& watch)
    : problem_(problem),
      options_(options),
      evaluator_(criterion_of(problem, options)),
      watch_(watch),
      best_s_(large_vector(problem.num_rows())),
      free_energy_(evaluator_.energy_at_rest()) {
  best_s_.setZero();
}

bool IterationMonitor::due(int iteration) const {
  return every_ || options_.stop == StopTest::kImpulse || iteration >= next_ ||
         iteration >= options_.max_iterations || out_of_time();
}

int IterationMonitor::undue(int iteration, int most) const {
  if (every_ || options_.stop == StopTest::kImpulse) return 1;
  return std::clamp(std::min(next_, options_.max_iterations) - iteration, 1, most);
}

bool IterationMonitor::judge(const Eigen::Ref<const Vector>& s, double impulse_change) {
  last_ = evaluator_(s);
  const double error = last_.guarded();
  if (error < best_error_) {
    best_error_ = error;
    best_s_ = evaluator_.impulse();
  }
  if (options_.stop == StopTest::kImpulse) return impulse_change <= options_.tol;
  return bipot::meets(options_, last_) &&
         prove_claim(problem_, options_, evaluator_.impulse(), last_).holds;
}

bool IterationMonitor::meets(const Eigen::Ref<const Vector>& s) {
  return judge(s, std::numeric_limits<double>::infinity());
}

/// The change since the iterate judged before, relative; infinite where there was none. In pieces, so
/// that what is read comes from memory once.
double IterationMonitor::replace_previous(int iteration, const Eigen::Ref<const Vector>& s) {
  const bool known = previous_.size() == s.size() && previous_iteration_ < iteration;
  if (previous_.size() != s.size()) previous_ = large_vector(s.size());
  double change2 = 0, norm2 = 0;
  for (Eigen::Index first = 0; first < s.size(); first += kPieceItems) {
    const auto size = std::min<Eigen::Index>(kPieceItems, s.size() - first);
    const auto now = s.segment(first, size);
    auto before = previous_.segment(first, size);
    if (known) {
      norm2 += now.squaredNorm();
      change2 += (now - before).squaredNorm();
    }
    before = now;
  }
  // Two iterates at 0 say nothing: 0/0. (0 is no solution here, or solve() had returned it.)
  return known && norm2 > 0 ? std::sqrt(change2 / norm2) : std::numeric_limits<double>::infinity();
}

bool IterationMonitor::stop(int iteration, const Eigen::Ref<const Vector>& s, double step,
                            bool moving) {
  iterations_ = iteration;
  if (!due(iteration)) return false;
  next_ = next_judged(iteration, portion_, roots_);

  const double change = replace_previous(iteration, s);
  const bool comparable = previous_iteration_ == iteration - 1;
  const bool met = judge(s, comparable ? change : std::numeric_limits<double>::infinity());

  if (options_.on_iteration) {
    options_.on_iteration({.iteration = iteration,
                           .seconds = seconds(),
                           .error = last_,
                           .step = step,
                           .count = count_contacts(problem_, evaluator_.impulse())});
  }
  free_energy_ = divergence_reference(iteration, last_, free_energy_);
  if (met) {
    best_s_ = evaluator_.impulse();
    best_error_ = last_.guarded();
  }
  StopVerdict verdict = stop_verdict(options_, {.iteration = iteration,
                                                .error = last_,
                                                .best_error = best_error_,
                                                .free_energy = free_energy_,
                                                .change = change,
                                                .moving = moving,
                                                .met = met});
  if (verdict.status == SolveStatus::kNotRun) {
    end_if_out_of_time(iteration);
  } else {
    end(verdict.status, std::move(verdict.message));
  }
  previous_iteration_ = iteration;
  return status_ != SolveStatus::kNotRun;
}

void IterationMonitor::end(SolveStatus status, std::string message) {
  status_ = status;
  message_ = std::move(message);
}

bool IterationMonitor::end_if_out_of_time(int iteration) {
  StopVerdict verdict = out_of_time_verdict(options_, cancelled(), seconds() >= options_.time_limit,
                                            iteration, best_error_);
  if (verdict.status == SolveStatus::kNotRun) return false;
  end(verdict.status, std::move(verdict.message));
  return true;
}

double IterationMonitor::seconds() const { return watch_.seconds(); }

bool IterationMonitor::cancelled() const { return options_.cancelled && options_.cancelled(); }

bool IterationMonitor::out_of_time() const {
  if (cancelled()) return true;
  return std::isfinite(options_.time_limit) && seconds() >= options_.time_limit;
}

double IterationMonitor::remaining_seconds() const {
  return std::max(0.0, options_.time_limit - seconds());
}

void IterationMonitor::end_setup() { setup_seconds_ = seconds(); }

SolveResult IterationMonitor::finish() {
  SolveResult result;
  result.status = status_;
  result.message = message_;
  result.s = best_s_;
  result.iterations = iterations_;
  result.setup_seconds = setup_seconds_;
  result.solve_seconds = seconds() - setup_seconds_;
  return result;
}

}  // namespace bipot
